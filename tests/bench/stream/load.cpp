#include "tests/bench/stream/load.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

#include "codec/live/live.h"
#include "codec/octree/frame_header.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/base/unix_time.h"
#include "common/net/websocket.h"
#include "pointreel/package.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/live_layer.h"
#include "tests/load/load_generator.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr unsigned kViewers = 200;
constexpr double kFps = 30.0;
constexpr std::uint32_t kFrames = 60;
/// The sizes of a frame's layers, in about the proportions of an octree: 10 Mbit/s at 30 frames per
/// second.
constexpr std::uint32_t kLayerBytes[] = {3'000, 9'000, 29'667};

std::string noise(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::string text(size, '\0');
  for (char& c : text) c = static_cast<char>(random());
  return text;
}

ByteView bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Makes a package of that rate. Its layers are noise, because the server never looks into them.
Result<void> make_reel(const fs::path& folder) {
  Manifest manifest;
  manifest.name = "noise";
  manifest.codec = "octree";
  manifest.entropy = "none";
  manifest.fps = kFps;
  manifest.duration_us = kFrames * 1'000'000ull / 30;
  manifest.depth_max = 10;
  manifest.bounds.grow(glm::dvec3(0.0));
  manifest.bounds.grow(glm::dvec3(1.0));
  manifest.layer_names = {"base", "middle", "full"};
  Segment segment;
  segment.cube = {glm::dvec3(0.0), 1.0};
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    segment.times_us.push_back(i * 1'000'000ull / 30);
    segment.points.push_back(1);
  }
  fs::create_directories(folder);
  for (std::size_t layer = 0; layer < manifest.layer_names.size(); ++layer) {
    LayerFile file;
    file.path = manifest.layer_names[layer] + ".prs";
    file.frames.assign(kFrames, {kLayerBytes[layer], 0, 0});
    file.bytes = std::uint64_t{kFrames} * kLayerBytes[layer];
    const std::string content = noise(file.bytes, layer);
    file.checksum = checksum_of(bytes_of(content));
    std::ofstream out(folder / file.path, std::ios::binary);
    if (!out.write(content.data(), static_cast<std::streamsize>(content.size()))) {
      return fail(ErrorCode::io, (folder / file.path).string() + ": cannot be written");
    }
    segment.layers.push_back(std::move(file));
  }
  manifest.segments.push_back(std::move(segment));
  std::ofstream out(folder / kManifestName, std::ios::binary);
  if (!(out << write_manifest(manifest))) {
    return fail(ErrorCode::io, (folder / kManifestName).string() + ": cannot be written");
  }
  return {};
}

/// The processor time that a process has used in seconds.
double cpu_seconds(pid_t pid) {
  std::ifstream in(fmt::format("/proc/{}/stat", pid));
  std::string text;
  std::getline(in, text);
  // The fields from number 3 on follow the name, which may contain anything. Fields 14 and 15 are
  // user and system time.
  std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
  std::string ignored;
  for (int i = 0; i < 11; ++i) fields >> ignored;
  double user = 0.0, system = 0.0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

/// Publishes noise at that rate until it is destroyed.
class NoisePublisher {
 public:
  static Result<std::unique_ptr<NoisePublisher>> start(const std::string& url) {
    auto socket = TRY(WebSocket::connect(url));
    LiveHello hello;
    hello.name = "noise";
    hello.codec = "octree";
    hello.entropy = "none";
    hello.fps = kFps;
    hello.layer_names = {"base", "middle", "full"};
    const std::string text = write_publisher_hello(hello, {LiveSecret{}});
    TRY(socket->send(bytes_of(text), WebSocket::Kind::text));
    return std::unique_ptr<NoisePublisher>(new NoisePublisher(std::move(socket)));
  }
  ~NoisePublisher() {
    ending_ = true;
    thread_.join();
  }

 private:
  explicit NoisePublisher(std::unique_ptr<WebSocket> socket)
      : socket_(std::move(socket)), thread_([this] { run(); }) {}

  void run() {
    std::string content = noise(*std::max_element(kLayerBytes, kLayerBytes + 3), 9);
    // The server looks at the header of each frame, with which its base begins.
    Bytes header;
    write_frame_header({.depth = 10, .layers = 3, .source_points = 1, .cube = {}}, 0, header);
    std::copy(header.begin(), header.end(), content.begin());
    auto due = std::chrono::steady_clock::now();
    for (std::uint32_t frame = 0; !ending_; ++frame) {
      const std::uint64_t captured = unix_time_us();
      for (std::uint8_t layer = 0; layer < 3; ++layer) {
        const Bytes message = write_live_layer({frame,
                                                layer,
                                                3,
                                                captured,
                                                1,
                                                {kLayerBytes[layer], 0, 0},
                                                bytes_of(content).subspan(0, kLayerBytes[layer])});
        if (!socket_->send(message, WebSocket::Kind::binary)) return;
      }
      due += std::chrono::microseconds(33'333);
      std::this_thread::sleep_until(due);
    }
  }

  const std::unique_ptr<WebSocket> socket_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

Result<json> measure_load(const char* name, const std::string& url, pid_t server,
                          const StreamOptions& options, std::vector<Bar>& bars) {
  LoadOptions load;
  load.url = url;
  load.viewers = kViewers;
  load.seconds = options.quick ? 2.0 : 15.0;
  const double before = cpu_seconds(server);
  const LoadFigures figures = TRY(pointreel::run_load(load));
  const double server_cores = (cpu_seconds(server) - before) / (load.seconds + load.warm_up);
  bars.push_back(
      {fmt::format("{} viewers at 10 Mbit/s, {}: frame delay, 99 % of the frames", kViewers, name),
       figures.delay_ms(0.99), "ms", 50.0});
  return json{{"viewers", kViewers},
              {"mbit_per_second_each", figures.bits_per_second() / 1e6 / kViewers},
              {"frames", figures.frames},
              {"incomplete", figures.incomplete},
              {"missing", figures.missing},
              {"broken", figures.broken},
              {"delay_ms",
               {{"median", figures.delay_ms(0.5)},
                {"p95", figures.delay_ms(0.95)},
                {"p99", figures.delay_ms(0.99)}}},
              {"server_cores", server_cores},
              {"generator_cores", figures.cpu_seconds / figures.seconds}};
}

}  // namespace

Result<json> run_load(const StreamOptions& options, std::vector<Bar>& bars) {
  const fs::path reel = options.scratch / "noise";
  TRY(make_reel(reel));
  e2e::Background server("pointreel-server",
                         {"serve", reel.string(), "--live", "--listen", "127.0.0.1:0"});
  const std::string address = e2e::server_address(server);
  if (address.empty()) return fail(ErrorCode::io, "pointreel-server: did not start");

  json package =
      TRY(measure_load("package", "http://" + address + "/noise", server.pid(), options, bars));
  const std::string stream = "ws://" + address + "/live/noise";
  const auto publisher = TRY(NoisePublisher::start(stream + "?publish"));
  json live = TRY(measure_load("live", stream, server.pid(), options, bars));
  return json{{"package", std::move(package)}, {"live", std::move(live)}};
}

}  // namespace pointreel::bench
