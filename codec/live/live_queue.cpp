#include "codec/live/live_queue.h"

#include <algorithm>
#include <utility>

namespace pointreel {

std::size_t LiveMessage::size() const { return bytes->size() + (chunks ? total(*chunks) : 0); }

std::array<ByteView, 4> LiveMessage::pieces() const {
  if (!chunks) return {*bytes};
  return {*bytes, chunks->geometry, chunks->colors, chunks->normals};
}

LiveMessage text_message(std::string_view text) {
  return {LiveMessage::Kind::text, std::make_shared<const Bytes>(text.begin(), text.end())};
}

LiveMessage layer_message(LiveLayer layer, Chunks<Bytes> chunks) {
  layer.sizes = {static_cast<std::uint32_t>(chunks.geometry.size()),
                 static_cast<std::uint32_t>(chunks.colors.size()),
                 static_cast<std::uint32_t>(chunks.normals.size())};
  return {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_header(layer)),
          std::make_shared<const Chunks<Bytes>>(std::move(chunks))};
}

void LiveQueue::hello(LiveMessage text, bool new_session) {
  hello_ = std::move(text);
  end_.reset();
  if (!new_session) return;
  sounds_.clear();
  frames_.clear();
  bytes_ = 0;
}

void LiveQueue::sound(LiveMessage message) {
  if (sounds_.size() == kMaxSounds) sounds_.pop_front();
  sounds_.push_back(std::move(message));
}

void LiveQueue::end(LiveMessage text) { end_ = std::move(text); }

void LiveQueue::push(std::uint32_t frame, std::uint8_t layer, std::uint8_t layers,
                     LiveMessage message) {
  if (layer == 0) begin_frame(frame, layers);
  // The frame began before the receiver joined.
  if (frames_.empty() || frames_.back().number != frame) return;
  Frame& newest = frames_.back();
  newest.cut = newest.cut || layer >= max_layers_ || layer != newest.next;
  if (newest.cut) {
    ++drops_.layers;
    return;
  }
  if (newest.messages.empty()) newest.first = layer;
  const std::size_t size = message.size();
  newest.messages.push_back(std::move(message));
  ++newest.next;
  bytes_ += size;
  if (bytes_ <= options_.bytes) return;
  drop_before_newest();
  while (bytes_ > options_.bytes && !newest.messages.empty() &&
         newest.first + newest.messages.size() > 1) {
    drop_finest(newest);
  }
}

void LiveQueue::begin_frame(std::uint32_t number, std::uint8_t layers) {
  if (!frames_.empty() && frames_.back().messages.empty()) frames_.pop_back();
  since_raise_ = std::min(since_raise_ + 1, kMaxPatience);
  if (frames_.size() + 1 > options_.frames) {
    frames_.emplace_back();
    drop_before_newest();
    frames_.pop_back();
    fall_behind(layers);
  } else if (max_layers_ < layers && ++calm_ >= patience_.wait()) {
    ++max_layers_;
    calm_ = 0;
    since_raise_ = 0;
  }
  frames_.emplace_back().number = number;
}

void LiveQueue::drop_finest(Frame& frame) {
  bytes_ -= frame.messages.back().size();
  frame.messages.pop_back();
  frame.cut = true;
  ++drops_.layers;
}

void LiveQueue::drop_before_newest() {
  while (frames_.size() > 1) {
    Frame& oldest = frames_.front();
    drops_.frames += oldest.first == 0 && !oldest.messages.empty() ? 1 : 0;
    while (!oldest.messages.empty()) drop_finest(oldest);
    frames_.pop_front();
  }
}

void LiveQueue::fall_behind(std::uint8_t layers) {
  max_layers_ = std::max(1, std::min<int>(max_layers_, layers) - 1);
  calm_ = 0;
  if (since_raise_ < kMaxPatience) {
    patience_.failed();  // the last additional layer was soon too much
  } else {
    patience_.succeeded();
  }
  since_raise_ = kMaxPatience;
}

std::optional<LiveMessage> LiveQueue::next() {
  if (hello_) return std::exchange(hello_, std::nullopt);
  if (!sounds_.empty()) {
    LiveMessage message = std::move(sounds_.front());
    sounds_.pop_front();
    return message;
  }
  if (drops_untold()) {
    LiveMessage message = text_message(write_drops(drops_));
    told_ = drops_;
    return message;
  }
  while (frames_.size() > 1 && frames_.front().messages.empty()) frames_.pop_front();
  if (frames_.empty() || frames_.front().messages.empty()) {
    return std::exchange(end_, std::nullopt);
  }
  Frame& oldest = frames_.front();
  LiveMessage message = std::move(oldest.messages.front());
  oldest.messages.pop_front();
  ++oldest.first;
  bytes_ -= message.size();
  return message;
}

}  // namespace pointreel
