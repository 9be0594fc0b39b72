#include "tests/bench/stream/watching.h"

#include <thread>

#include "client/source/open_source.h"
#include "common/base/try.h"

namespace pointreel::bench {

Watching::Watching(std::unique_ptr<Source> source, const Options& options) {
  ReelPlayback::Options playing;
  playing.prepare.mode = options.mode;
  playing.remote = true;
  if (options.keep_nothing) playing.store_bytes = 0;
  Camera camera;
  camera.frame_bounds(source->manifest().bounds, 1.0);
  camera.zoom(0.1);
  playback_ =
      std::make_unique<ReelPlayback>(std::move(source), playing, camera, glm::ivec2(1280, 720),
                                     [](std::uint32_t, const Error&) {});
}

Result<std::unique_ptr<Watching>> Watching::start(const std::string& url, const Options& options) {
  return std::unique_ptr<Watching>(new Watching(TRY(open_source(url)), options));
}

bool Watching::until(const std::function<bool(const ReelPlayback::Update&)>& done,
                     std::chrono::milliseconds timeout) {
  const auto end = Clock::TimePoint::clock::now() + timeout;
  for (;;) {
    const auto now = Clock::TimePoint::clock::now();
    if (done(playback_->update(now))) return true;
    if (now > end) return false;
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
}

}  // namespace pointreel::bench
