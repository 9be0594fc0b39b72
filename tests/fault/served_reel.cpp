#include "tests/fault/served_reel.h"

#include <cmath>
#include <csignal>

#include <fmt/format.h>

#include "common/cloud/ply.h"
#include "server/pack/packer.h"

namespace pointreel {
namespace {

constexpr int kFrames = 240;  // 8 seconds
constexpr int kPoints = 1500;

/// A ball that turns; of no two frames alike.
PointCloud ball(int frame) {
  PointCloud cloud;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / kPoints;
    const double angle = 2.399963 * i + 0.01 * frame;
    const double r = std::sqrt(1.0 - z * z);
    cloud.positions.push_back(glm::vec3(r * std::cos(angle), r * std::sin(angle), z));
    cloud.colors.push_back(glm::u16vec3(257 * (i % 256), 257 * (frame % 256), 257 * 200));
  }
  return cloud;
}

}  // namespace

Result<double> make_ball_reel(const std::filesystem::path& folder) {
  const std::filesystem::path clouds = folder.string() + ".clouds";
  std::filesystem::create_directories(clouds);
  for (int i = 0; i < kFrames; ++i)
    if (const auto written = write_ply(clouds / fmt::format("{}.ply", i), ball(i)); !written)
      return tl::unexpected(written.error());
  PackOptions options;
  options.inputs = {clouds};
  options.output = folder;
  OctreeOptions octree;
  octree.depth = DepthRule::fixed(10);
  options.encode.codec = octree;
  const auto packed = pack(options);
  if (!packed) return tl::unexpected(packed.error());
  return 8.0 * static_cast<double>(packed->bytes) * 30.0 / kFrames;
}

ServerProcess::ServerProcess(const std::filesystem::path& reel, int port,
                             const std::vector<std::string>& options) {
  std::vector<std::string> arguments = {"serve", reel.string(), "--listen",
                                        fmt::format("127.0.0.1:{}", port)};
  arguments.insert(arguments.end(), options.begin(), options.end());
  process_ = std::make_unique<e2e::Background>("pointreel-server", arguments);
  const std::string line = process_->first_line();
  port_ = std::atoi(line.substr(line.rfind(':') + 1).c_str());
}

void ServerProcess::kill() { process_->end(SIGKILL); }

std::string ServerProcess::address() const { return fmt::format("127.0.0.1:{}", port_); }

}  // namespace pointreel
