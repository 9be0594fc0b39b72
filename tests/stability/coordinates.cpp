#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "codec/distance/distance.h"
#include "codec/files/cloud_file.h"
#include "common/base/try.h"
#include "datasets_synthetic/hard_case.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "tests/stability/check.h"
#include "tests/stability/clouds.h"

namespace pointreel::stability {
namespace {

constexpr std::size_t kPoints = 2000;

Result<PointCloud> read(const PlyTable& table) {
  const std::string text = ply_text(table, PlyFormat::little_endian);
  const auto* data = reinterpret_cast<const std::uint8_t*>(text.data());
  LoadedCloud loaded = TRY(read_cloud(ByteView(data, text.size())));
  if (loaded.cloud.size() != table.rows.size()) return fail("points were lost");
  return std::move(loaded.cloud);
}

/// Sends doubles through a PLY file, a cloud and a codec, and compares the result with the doubles
/// in the file.
void check_offset(double offset, int depth, Checks& checks) {
  const PlyTable table = ball(kPoints, {offset, -0.5 * offset, offset}, PlyType::float64);
  std::vector<glm::dvec3> truth;
  for (const auto& row : table.rows) truth.emplace_back(row[0], row[1], row[2]);
  const std::string subject = fmt::format("offset {:g}, depth {}", offset, depth);
  const auto add = [&](const std::string& name, const std::string& outcome, bool passed) {
    checks.push_back({"coordinates", subject, kAllowed, name + ": " + outcome, passed});
  };
  const auto cloud = read(table);
  if (!cloud) return add("read", cloud.error().message, false);
  const Cube cube = bounding_cube(bounds(*cloud));
  const double cell = std::ldexp(cube.edge, -depth);

  double worst = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const glm::dvec3 off = glm::abs(cloud->world(i) - truth[i]);
    worst = std::max({worst, off.x, off.y, off.z});
  }
  add("PLY to cloud", fmt::format("{:.2g} units, {:.5f} cells", worst, worst / cell),
      worst <= 0.5 * cell);
  // World coordinates are doubles; their own rounding this far from zero is not an error of the
  // codec.
  const double given = 2.0 * offset * 0x1p-52 / cell;
  for (const Setting& setting : settings(depth)) {
    const auto frame = encode_frame(*cloud, cube, setting.options);
    const auto decoded = frame ? decode_frame(layer_views(frame->layers))
                               : Result<DecodedFrame>(tl::unexpected(frame.error()));
    if (!decoded) {
      add(setting.name, decoded.error().message, false);
    } else if (decoded->svo) {
      const double cells = round_trip_cells(*cloud, truth, *decoded);
      add(setting.name, fmt::format("{:.4f} cells on an axis", cells),
          cells <= allowed_cells(setting, depth) + given);
    } else {
      const auto distance = cloud_distance(*cloud, decoded->cloud);
      const double cells = distance ? distance->max() / cell : HUGE_VAL;
      add(setting.name, fmt::format("{:.4f} cells (half of the diagonal is 0.866)", cells),
          cells <= std::sqrt(3.0) * (allowed_cells(setting, depth) + given));
    }
  }
}

}  // namespace

Checks coordinate_checks() {
  Checks checks;
  for (const double offset : {0.0, 1e3, 1e6, 1e9}) {
    for (const int depth : {10, 16}) check_offset(offset, depth, checks);
  }
  return checks;
}

}  // namespace pointreel::stability
