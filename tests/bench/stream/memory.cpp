#include "tests/bench/stream/memory.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "codec/files/ply.h"
#include "common/base/try.h"
#include "tests/bench/program.h"
#include "tests/bench/stream/resident_memory.h"
#include "tests/e2e/server_address.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kReelFrames = 60;
constexpr double kMemoryFps = 30.0;
/// Memory counts as constant if it grows by less than this per thousand frames or connections.
constexpr double kFlatKib = 16.0;

/// Makes a reel of tiny frames, which are quick to play, so that memory kept for each frame would
/// show.
Result<void> make_reel(const fs::path& clouds, const fs::path& reel) {
  fs::create_directories(clouds);
  for (int frame = 0; frame < kReelFrames; ++frame) {
    PointCloud cloud;
    for (int i = 0; i < 200; ++i) {
      const double angle = 2.4 * i, height = 0.01 * i;
      cloud.positions.emplace_back(std::cos(angle + 0.1 * frame), height, std::sin(angle));
      cloud.colors.emplace_back(257 * i, 40'000, 300 * frame);
    }
    TRY(write_ply(clouds / fmt::format("{:03}.ply", frame), cloud));
  }
  TRY(run_program("pointreel-server",
                  {"pack", "-i", clouds.string(), "-o", reel.string(), "--depth", "10"}));
  return {};
}

/// Sends a request on a new connection. Returns false if there is no answer.
bool connect_ask_disconnect(std::uint16_t port, const std::string& target) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  bool answered = false;
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
    const std::string request = "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
    char some[4096];
    answered = ::send(descriptor, request.data(), request.size(), MSG_NOSIGNAL) > 0 &&
               ::recv(descriptor, some, sizeof(some), 0) > 0;
  }
  ::close(descriptor);
  return answered;
}

json to_json(const MemoryGrowth& growth, double unit, double slope) {
  return {{"samples", growth.size()},
          {"first_kib", growth.first_kib()},
          {"last_kib", growth.last_kib()},
          {"slope_kib", slope},
          {"per", unit}};
}

}  // namespace

Result<json> run_memory(const StreamOptions& options, std::vector<Bar>& bars) {
  const double frames = options.quick ? 6'000 : 100'000;
  const int connections = options.quick ? 1'000 : 10'000;
  const fs::path clouds = options.scratch / "memory-clouds", reel = options.scratch / "memory";
  TRY(make_reel(clouds, reel));

  e2e::Background server("pointreel-server", {"serve", reel.string(), "--listen", "127.0.0.1:0"});
  const std::string address = e2e::server_address(server), url = "http://" + address;
  if (address.empty()) return fail(ErrorCode::io, "pointreel-server: did not start");
  const std::uint16_t port = e2e::port_of(address);

  // The picture is small, because drawing is not what is measured.
  const fs::path report = options.scratch / "memory.json";
  MemoryGrowth client, serving, connecting;
  {
    e2e::Background player(
        "pointreel",
        {"play", url + "/memory", "--mode", "point", "--offscreen", "32x32", "--loop", "--duration",
         fmt::format("{}", frames / kMemoryFps), "--json", report.string()});
    const auto begin = std::chrono::steady_clock::now();
    while (player.running()) {
      const double seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      if (const double kib = resident_kib(player.pid()); kib > 0.0) client.add(seconds, kib);
      serving.add(seconds, resident_kib(server.pid()));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  std::ifstream in(report);
  const json played = json::parse(in, nullptr, false);
  if (played.is_discarded()) {
    return fail(ErrorCode::io, "pointreel play: ended without writing its report");
  }
  const double shown = played["frames_shown"], seconds = played["seconds"];
  if (shown < frames - 1.0) {
    return fail(fmt::format("pointreel play: showed only {} of {} frames", shown, frames));
  }

  for (int i = 0; i < connections; ++i) {
    if (!connect_ask_disconnect(port, "/memory/reel.json")) {
      return fail(ErrorCode::io, fmt::format("connection {}: got no answer", i));
    }
    if (i % 20 == 0) connecting.add(i, resident_kib(server.pid()));
  }

  // The growth per thousand frames or connections.
  const double client_slope = client.slope(1000.0 * seconds / shown);
  const double serving_slope = serving.slope(1000.0 * seconds / shown);
  const double connecting_slope = connecting.slope(1000.0);
  bars.push_back({"memory of the client per 1,000 frames", client_slope, "KiB", kFlatKib});
  bars.push_back({"memory of the server per 1,000 frames", serving_slope, "KiB", kFlatKib});
  bars.push_back({"memory of the server per 1,000 connections", connecting_slope, "KiB", kFlatKib});
  return json{{"frames", shown},
              {"seconds_played", seconds},
              {"connections", connections},
              {"client", to_json(client, 1000.0, client_slope)},
              {"server_playing", to_json(serving, 1000.0, serving_slope)},
              {"server_connecting", to_json(connecting, 1000.0, connecting_slope)}};
}

}  // namespace pointreel::bench
