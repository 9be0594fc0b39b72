#include "client/bindings/frames/frame_publisher.h"

#include <utility>

#include <fmt/format.h>

#include "codec/core/scalar_fields.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/base/unix_time.h"
#include "common/net/url.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace {

/// Before 2001 no frame was captured whose clock was right. Clocks of cameras may be a little
/// ahead.
constexpr std::uint64_t kEarliest = 1'000'000'000'000'000, kMostAhead = 60'000'000;

}  // namespace

FramePublisher::FramePublisher(OutboxOptions outbox, const EncodingOptions& options)
    : options_(options),
      identity_(outbox.url),
      grid_(options),
      sender_(std::move(outbox), reel_head(options), identity_.get()) {}

Result<std::unique_ptr<FramePublisher>> FramePublisher::open(const std::string& url,
                                                             const std::string& token,
                                                             const std::string& ca_file,
                                                             const EncodingOptions& options,
                                                             const std::stop_token& stop) {
  OutboxOptions outbox;
  outbox.url = TRY(publishing_address(url));
  TRY(check_token(token));
  outbox.token = token;
  outbox.ca_file = ca_file;
  if (!is_frame_rate(options.fps)) return fail(ErrorCode::argument, "fps is out of range");
  EncodingOptions named = options;
  if (named.name.empty()) named.name = stream_name_of(url);
  named.encode.executor = tbb_executor();
  std::unique_ptr<FramePublisher> publisher(new FramePublisher(std::move(outbox), named));
  publisher->sender_.outbox().wait_until_tried(stop);
  if (stop.stop_requested()) return fail(ErrorCode::cancelled, url + ": connecting was cancelled");
  if (auto failure = publisher->sender_.outbox().failure()) return tl::unexpected(*failure);
  return publisher;
}

Result<void> FramePublisher::send(const PointCloud& cloud,
                                  std::optional<std::uint64_t> capture_us) {
  if (auto failure = sender_.outbox().failure()) return tl::unexpected(*failure);
  const std::uint64_t now = unix_time_us(), time = capture_us.value_or(now);
  if (time < kEarliest || time > now + kMostAhead)
    return fail(
        ErrorCode::argument,
        fmt::format("a frame of a live stream was captured at {} s of Unix time, but now it "
                    "is {} s: give the time of its capture, or none",
                    time / 1'000'000, now / 1'000'000));
  return or_out_of_memory([&]() -> Result<void> {
    const Box box = bounds(cloud);
    const Grid grid = TRY(grid_.of(cloud, box));
    EncodedFrame frame = TRY(encode_frame(cloud, grid.cube, grid.encode));
    const auto scalars = frame.has_scalars ? ranges_of(cloud) : std::vector<ScalarRange>();
    sender_.send(std::move(frame), {box, cloud.has_colors(), cloud.has_normals(), scalars}, time);
    return {};
  });
}

}  // namespace pointreel
