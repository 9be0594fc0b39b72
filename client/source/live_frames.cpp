#include "client/source/live_frames.h"

#include <utility>

namespace pointreel {

void LiveFrames::add(LiveHello hello) {
  if (!hello_ || hello_->session != hello.session) {
    // Numbers begin anew, so that nothing from before may count as newer.
    coming_.reset();
    come_.reset();
    newest_.reset();
    given_.reset();
  }
  hello_ = std::move(hello);
}

void LiveFrames::add(const LiveLayer& layer, SharedBytes bytes, TimePoint now) {
  if (!hello_ || layer.layers > hello_->layer_names.size()) {
    ++counts_.bad;
    return;
  }
  if (layer.layer == 0) {
    // Over a new connection the newest frame may come once more. Older ones are of no use.
    if (!newer(layer.frame) && layer.frame != newest_) {
      ++counts_.bad;
      return;
    }
    if (newer(layer.frame)) keep_coming();
    newest_ = layer.frame;
    coming_ = LiveFrame{layer.frame, layer.capture_us, {}, layer.layers};
  } else if (!coming_ || coming_->number != layer.frame || layer.layers != coming_->layers_sent ||
             layer.layer != coming_->frame.layers.size()) {
    ++counts_.bad;
    return;
  }
  counts_.bytes += bytes.size();
  newest_layer_ = now;
  coming_->frame.layers.push_back({std::move(bytes), layer.sizes});
  if (coming_->frame.layers.size() == coming_->layers_sent) keep_coming();
}

/// The frame that is coming may be given as it is, unless it was given with these layers before.
void LiveFrames::keep_coming() {
  if (!coming_) return;
  const bool known = given_ == coming_->number && coming_->frame.layers.size() <= given_layers_;
  if (!known) {
    if (come_ && come_->number != coming_->number && come_->number != given_) ++counts_.skipped;
    come_ = std::move(coming_);
  }
  coming_.reset();
}

void LiveFrames::reconnected() {
  ++counts_.reconnections;
  dropped_before_ = counts_.dropped;
  keep_coming();
}

std::optional<LiveFrames::TimePoint> LiveFrames::due() const {
  if (come_) return newest_layer_;
  const bool more =
      coming_ && (given_ != coming_->number || coming_->frame.layers.size() > given_layers_);
  if (!more) return std::nullopt;
  return newest_layer_ + patience_;
}

std::optional<LiveFrame> LiveFrames::next(TimePoint now) {
  if (const auto at = due(); !at || now < *at) return std::nullopt;
  if (!come_) come_ = *coming_;  // a copy: the rest may still come
  if (given_ != come_->number) ++counts_.frames;
  given_ = come_->number;
  given_layers_ = come_->frame.layers.size();
  return std::exchange(come_, std::nullopt);
}

}  // namespace pointreel
