#include "tests/fault/served_reel.h"

#include <csignal>

#include <fmt/format.h>

#include "codec/files/ply.h"
#include "server/pack/packer.h"
#include "tests/e2e/server_address.h"
#include "tests/fault/turning_ball.h"

namespace pointreel {
namespace {

constexpr int kReelFrames = 240;  // 8 seconds

}  // namespace

Result<double> make_ball_reel(const std::filesystem::path& folder) {
  const std::filesystem::path clouds = folder.string() + ".clouds";
  std::filesystem::create_directories(clouds);
  for (int i = 0; i < kReelFrames; ++i)
    if (const auto written = write_ply(clouds / fmt::format("{}.ply", i), turning_ball(i));
        !written)
      return tl::unexpected(written.error());
  PackOptions options;
  options.inputs = {clouds};
  options.output = folder;
  OctreeOptions octree;
  octree.depth = DepthRule::fixed(10);
  options.encode.codec = octree;
  const auto packed = pack(options);
  if (!packed) return tl::unexpected(packed.error());
  return 8.0 * static_cast<double>(packed->bytes) * 30.0 / kReelFrames;
}

ServerProcess::ServerProcess(const std::filesystem::path& reel, int port,
                             const std::vector<std::string>& options) {
  std::vector<std::string> arguments = {"serve", reel.string(), "--listen",
                                        fmt::format("127.0.0.1:{}", port)};
  arguments.insert(arguments.end(), options.begin(), options.end());
  process_ = std::make_unique<e2e::Background>("pointreel-server", arguments);
  port_ = e2e::port_of(e2e::server_address(*process_));
}

void ServerProcess::kill() { process_->end(SIGKILL); }

std::string ServerProcess::address() const { return fmt::format("127.0.0.1:{}", port_); }

}  // namespace pointreel
