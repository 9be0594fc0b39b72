#include "client/source/live_assembler.h"

#include <algorithm>
#include <utility>

namespace pointreel {

void LiveAssembler::add(LiveHello hello) {
  {
    const std::lock_guard lock(mutex_);
    if (!hello_ || hello_->session != hello.session) {
      // Numbers begin anew, so that nothing from before may count as newer.
      coming_.reset();
      come_.reset();
      newest_.reset();
      given_.reset();
    }
    hello_ = std::move(hello);
  }
  changed_.notify_all();
}

void LiveAssembler::add(const LiveLayer& layer, SharedBytes bytes) {
  {
    const std::lock_guard lock(mutex_);
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
    newest_layer_ = Clock::now();
    coming_->frame.layers.push_back({std::move(bytes), layer.sizes});
    if (coming_->frame.layers.size() == coming_->layers_sent) keep_coming();
  }
  changed_.notify_all();
}

/// The frame that is coming may be given as it is, unless it was given with these layers before.
void LiveAssembler::keep_coming() {
  if (!coming_) return;
  const bool known = given_ == coming_->number && coming_->frame.layers.size() <= given_layers_;
  if (!known) {
    if (come_ && come_->number != coming_->number && come_->number != given_) ++counts_.skipped;
    come_ = std::move(coming_);
  }
  coming_.reset();
}

void LiveAssembler::add_bad() {
  const std::lock_guard lock(mutex_);
  ++counts_.bad;
}

void LiveAssembler::set_dropped(std::uint64_t layers) {
  const std::lock_guard lock(mutex_);
  counts_.dropped = dropped_before_ + layers;
}

void LiveAssembler::reconnected() {
  {
    const std::lock_guard lock(mutex_);
    ++counts_.reconnections;
    dropped_before_ = counts_.dropped;
    keep_coming();
  }
  changed_.notify_all();
}

std::optional<LiveHello> LiveAssembler::hello(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return hello_ || cancelled_; });
  return hello_;
}

std::optional<LiveFrame> LiveAssembler::next(std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  std::unique_lock lock(mutex_);
  while (!cancelled_) {
    if (!come_ && coming_) {
      const bool more = given_ != coming_->number || coming_->frame.layers.size() > given_layers_;
      const auto patient_until = newest_layer_ + patience_;
      if (more && Clock::now() >= patient_until)
        come_ = *coming_;  // a copy: the rest may still come
      else if (more && patient_until < deadline) {
        changed_.wait_until(lock, patient_until);
        continue;
      }
    }
    if (come_) {
      if (given_ != come_->number) ++counts_.frames;
      given_ = come_->number;
      given_layers_ = come_->frame.layers.size();
      return std::exchange(come_, std::nullopt);
    }
    if (changed_.wait_until(lock, deadline) == std::cv_status::timeout &&
        Clock::now() >= deadline && !come_)
      return std::nullopt;
  }
  return std::nullopt;
}

LiveCounts LiveAssembler::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void LiveAssembler::cancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  changed_.notify_all();
}

}  // namespace pointreel
