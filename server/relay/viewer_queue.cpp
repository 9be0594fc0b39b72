#include "server/relay/viewer_queue.h"

#include <algorithm>
#include <utility>

namespace pointreel {

LiveMessage text_message(std::string_view text) {
  return {LiveMessage::Kind::text, std::make_shared<const Bytes>(text.begin(), text.end())};
}

void ViewerQueue::hello(LiveMessage text, bool new_session) {
  hello_ = std::move(text);
  end_.reset();
  if (!new_session) return;
  frames_.clear();
  bytes_ = 0;
}

void ViewerQueue::end(LiveMessage text) { end_ = std::move(text); }

void ViewerQueue::push(std::uint32_t frame, std::uint8_t layer, std::uint8_t layers,
                       LiveMessage message) {
  if (layer == 0) begin_frame(frame, layers);
  if (frames_.empty() || frames_.back().number != frame) return;  // it began before the viewer did
  Frame& newest = frames_.back();
  newest.cut = newest.cut || layer >= cap_ || layer != newest.next;
  if (newest.cut) {
    ++drops_.layers;
    return;
  }
  if (newest.messages.empty()) newest.first = layer;
  ++newest.next;
  bytes_ += message.bytes->size();
  newest.messages.push_back(std::move(message));
  if (bytes_ <= limits_.bytes) return;
  drop_before_newest();
  while (bytes_ > limits_.bytes && !newest.messages.empty() &&
         newest.first + newest.messages.size() > 1) {
    drop_finest(newest);
  }
}

void ViewerQueue::begin_frame(std::uint32_t number, std::uint8_t layers) {
  if (!frames_.empty() && frames_.back().messages.empty()) frames_.pop_back();
  since_raise_ = std::min(since_raise_ + 1, kMostPatience);
  if (frames_.size() + 1 > limits_.frames) {
    frames_.emplace_back();
    drop_before_newest();
    frames_.pop_back();
    fall_behind(layers);
  } else if (cap_ < layers && ++calm_ >= patience_) {
    ++cap_;
    calm_ = 0;
    since_raise_ = 0;
  }
  frames_.emplace_back().number = number;
}

void ViewerQueue::drop_finest(Frame& frame) {
  bytes_ -= frame.messages.back().bytes->size();
  frame.messages.pop_back();
  frame.cut = true;
  ++drops_.layers;
}

/// Oldest frames first, and of each the finest layers.
void ViewerQueue::drop_before_newest() {
  while (frames_.size() > 1) {
    Frame& oldest = frames_.front();
    drops_.frames += oldest.first == 0 && !oldest.messages.empty() ? 1 : 0;
    while (!oldest.messages.empty()) drop_finest(oldest);
    frames_.pop_front();
  }
}

void ViewerQueue::fall_behind(std::uint8_t layers) {
  cap_ = std::max(1, std::min<int>(cap_, layers) - 1);
  calm_ = 0;
  // A raise that did not last was made too soon.
  patience_ =
      since_raise_ < kMostPatience ? std::min(2 * patience_, kMostPatience) : kFirstPatience;
  since_raise_ = kMostPatience;
}

std::optional<LiveMessage> ViewerQueue::next() {
  if (hello_) return std::exchange(hello_, std::nullopt);
  if (drops_ != told_) {
    told_ = drops_;
    return text_message(write_drops(drops_));
  }
  while (frames_.size() > 1 && frames_.front().messages.empty()) frames_.pop_front();
  if (frames_.empty() || frames_.front().messages.empty()) {
    return std::exchange(end_, std::nullopt);
  }
  Frame& oldest = frames_.front();
  LiveMessage message = std::move(oldest.messages.front());
  oldest.messages.pop_front();
  ++oldest.first;
  bytes_ -= message.bytes->size();
  return message;
}

}  // namespace pointreel
