#include "client/source/video_groups.h"

#include <algorithm>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "codec/video/video_decoder.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Playback passes from one group to the next; several reels, or a drag, need a few more.
constexpr std::size_t kKeptDecodings = 4;
/// Threads that make frames ask for the next ones in any order.
constexpr std::size_t kKeptPictures = 4;

/// A group that is being decoded.
class Decoding {
 public:
  explicit Decoding(std::shared_ptr<const FetchedGroup> group) : group_(std::move(group)) {}

  const FetchedGroup* group() const { return group_.get(); }

  Result<VideoPictures> decode(std::uint32_t index, const DecodeLimits& limits) {
    const std::lock_guard lock(mutex_);
    for (const auto& [kept, pictures] : recent_)
      if (kept == index) return pictures;
    if (index < next_) next_ = 0;
    while (true) {
      if (limits.stopped && limits.stopped())
        return fail(ErrorCode::cancelled, "the frame is not wanted any more");
      auto pictures = decoder_.next(group_->view(next_), limits);
      if (!pictures) {
        next_ = 0;
        return pictures;
      }
      recent_.emplace_back(next_, *pictures);
      if (recent_.size() > kKeptPictures) recent_.pop_front();
      if (next_++ == index) return pictures;
    }
  }

 private:
  const std::shared_ptr<const FetchedGroup> group_;
  std::mutex mutex_;
  VideoDecoder decoder_;
  std::uint32_t next_ = 0;
  std::deque<std::pair<std::uint32_t, VideoPictures>> recent_;
};

/// The groups that are being decoded, the one used last in front.
class Decodings {
 public:
  std::shared_ptr<Decoding> of(const std::shared_ptr<const FetchedGroup>& group) {
    const std::lock_guard lock(mutex_);
    for (auto it = all_.begin(); it != all_.end(); ++it) {
      if ((*it)->group() != group.get()) continue;
      std::rotate(all_.begin(), it, it + 1);
      return all_.front();
    }
    all_.push_front(std::make_shared<Decoding>(group));
    if (all_.size() > kKeptDecodings) all_.pop_back();
    return all_.front();
  }

 private:
  std::mutex mutex_;
  std::deque<std::shared_ptr<Decoding>> all_;
};

Decodings& decodings() {
  static Decodings all;
  return all;
}

}  // namespace

Result<DecodedFrame> decode_video(const FetchedLayer& layer, const DecodeLimits& limits) {
  const VideoPictures pictures = TRY(decodings().of(layer.group)->decode(layer.index, limits));
  return frame_of(pictures, limits);
}

}  // namespace pointreel
