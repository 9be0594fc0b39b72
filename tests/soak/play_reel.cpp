#include <atomic>
#include <cmath>
#include <memory>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/playback/reel_playback.h"
#include "client/source/open_source.h"
#include "codec/files/ply.h"
#include "common/base/try.h"
#include "server/pack/packer.h"
#include "server/serve/http_server.h"
#include "tests/soak/scenario.h"

namespace pointreel::soak {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
namespace fs = std::filesystem;

constexpr std::uint32_t kFrames = 40;

/// The number of points, which identifies a frame.
std::uint32_t points_of(std::uint32_t frame) { return 400 + 7 * frame; }

Result<void> pack_reel(const fs::path& clouds, const fs::path& reel) {
  fs::create_directories(clouds);
  for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
    PointCloud cloud;
    for (std::uint32_t i = 0; i < points_of(frame); ++i) {
      const double angle = 2.399963 * i + 0.1 * frame, z = 1.0 - 2.0 * (i + 0.5) / points_of(frame);
      const double r = std::sqrt(1.0 - z * z);
      cloud.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
      cloud.normals.push_back(cloud.positions.back());
      cloud.colors.emplace_back(257 * (i % 256), 257 * frame, 20'000);
    }
    TRY(write_ply(clouds / fmt::format("{:03}.ply", frame), cloud));
  }
  PackOptions options;
  options.inputs = {clouds};
  options.output = reel;
  options.segment_frames = 7;
  options.threads = 1;  // ThreadSanitizer does not understand how TBB passes work to threads
  OctreeOptions octree;
  octree.depth = DepthRule::fixed(11);
  options.encode.codec = octree;
  TRY(pack(options));
  return {};
}

/// Connects, sends a request that may be damaged, and disconnects, with or without an answer.
void knock(std::uint16_t port, std::mt19937_64& random) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
    std::string text = "GET /reel/reel.json HTTP/1.1\r\nHost: localhost\r\n\r\n";
    if (random() % 2 == 0) text[random() % text.size()] = static_cast<char>(random());
    if (random() % 3 == 0) text.resize(random() % text.size());
    (void)!::send(descriptor, text.data(), text.size(), MSG_NOSIGNAL);
    char some[512];
    if (random() % 2 == 0) (void)!::recv(descriptor, some, sizeof(some), MSG_DONTWAIT);
  }
  ::close(descriptor);
}

Result<void> check(const SceneFrame& frame) {
  if (frame.points == points_of(frame.index)) return {};
  return fail(fmt::format("frame {} has {} points instead of {}", frame.index, frame.points,
                          points_of(frame.index)));
}

Camera camera_for(const Manifest& manifest) {
  Camera camera;
  camera.frame_bounds(manifest.bounds, 1.5);
  return camera;
}

void act(ReelPlayback& reel, Camera& camera, std::mt19937_64& random) {
  const auto now = steady_clock::now();
  switch (random() % 8) {
    case 0:
      reel.toggle_play(now);
      break;
    case 1:
      reel.seek_by(static_cast<std::int64_t>(random() % 2'000'000) - 1'000'000, now);
      break;
    case 2:
      reel.step(random() % 2 == 0 ? 1 : -1, now);
      break;
    case 3:
      reel.set_speed(0.1 + 0.1 * static_cast<double>(random() % 40), now);
      break;
    case 4:
      reel.toggle_loop(now);
      break;
    case 5:
      reel.set_prepare_options({.mode = static_cast<DrawMode>(random() % 3)});
      break;
    default:
      camera.distance = 1.0 + static_cast<double>(random() % 100);
      reel.look(camera, {480, 320});
  }
}

}  // namespace

Outcome play_reel(const Options& options) {
  const fs::path reel_folder = options.scratch / "reel";
  TRY(pack_reel(options.scratch / "clouds", reel_folder));
  HttpServerOptions serving;
  serving.listen = {"127.0.0.1", 0};
  Catalog catalog = TRY(Catalog::load({reel_folder}));
  const auto server = TRY(HttpServer::start(std::move(catalog), serving));
  const auto link =
      TRY(LinkEmulator::start({.target = fmt::format("127.0.0.1:{}", server->port())}));

  auto source = TRY(open_source("http://" + link->address() + "/reel"));
  Camera camera = camera_for(source->manifest());
  ReelPlayback::Options playing;
  playing.remote = true;
  ReelPlayback reel(std::move(source), playing, camera, {480, 320},
                    [](std::uint32_t, const Error&) {});  // broken frames are expected

  std::atomic<bool> ending{false};
  std::thread visitors([&, random = std::mt19937_64(options.seed + 1)]() mutable {
    while (!ending) {
      knock(server->port(), random);
      std::this_thread::sleep_for(milliseconds(5));  // many visitors, and time left for the rest
    }
  });
  const auto end_visitors = [&] {
    ending = true;
    visitors.join();
  };

  std::mt19937_64 random(options.seed);
  const auto begin = steady_clock::now();
  auto next_fault = begin, next_action = begin;
  std::uint64_t shown = 0;
  std::shared_ptr<const SceneFrame> last;
  const auto look_at_frame = [&]() -> Result<void> {
    const auto update = reel.update(steady_clock::now());
    if (!update.frame || update.frame == last) return {};
    last = update.frame;
    ++shown;
    return check(*last);
  };
  while (steady_clock::now() - begin < options.time) {
    const auto now = steady_clock::now();
    if (now >= next_fault) {
      worsen(*link, random);
      next_fault = now + milliseconds(100 + random() % 500);
    }
    if (now >= next_action) {
      act(reel, camera, random);
      next_action = now + milliseconds(random() % 200);
    }
    if (auto good = look_at_frame(); !good) {
      end_visitors();
      return tl::unexpected(good.error());
    }
    std::this_thread::sleep_for(milliseconds(2));  // more often than any display draws
  }

  // Once the link is good, every frame must arrive, no matter what happened before. What was given
  // up on the bad link is tried again in the second round.
  link->set({});
  Result<void> good;
  for (const bool must_come : {false, true}) {
    for (std::uint32_t frame = 0; frame < kFrames && good; ++frame) {
      FrameBuffer::State state = FrameBuffer::State::waiting;
      for (int tries = 0; tries < 600 && state == FrameBuffer::State::waiting; ++tries)
        state = reel.await(frame, milliseconds(50));
      const auto best = reel.best();
      if (state == FrameBuffer::State::ready && best && best->index == frame)
        good = check(*best);
      else if (must_come || state == FrameBuffer::State::waiting)
        good = fail(fmt::format("frame {} did not come over a good link", frame));
    }
  }
  end_visitors();
  if (!good) return tl::unexpected(good.error());
  return fmt::format("{} frames shown, {} broken, {} bits flipped, {} connections", shown,
                     reel.errors(), link->statistics().flipped_bits,
                     link->statistics().connections);
}

}  // namespace pointreel::soak
