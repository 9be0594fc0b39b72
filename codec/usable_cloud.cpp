#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/cloud_file.h"
#include "common/base/concat.h"
#include "common/surface/normals.h"

namespace pointreel {
namespace {

/// "1 point", "2 points".
std::string count(std::size_t n, std::string_view singular) {
  return concat(n, " ", singular, n == 1 ? "" : "s");
}

std::vector<std::string> warnings_of(const SanitizeReport& report) {
  std::vector<std::string> warnings;
  if (report.dropped_positions > 0) {
    warnings.push_back(
        concat("dropped ", count(report.dropped_positions, "point"), " without a finite position"));
  }
  if (report.unknown_normals > 0) {
    warnings.push_back(concat(count(report.unknown_normals, "point"),
                              report.unknown_normals == 1 ? " has" : " have", " no usable normal"));
  }
  if (report.unknown_radii > 0) {
    warnings.push_back(concat("replaced ", count(report.unknown_radii, "unusable radius value")));
  }
  return warnings;
}

}  // namespace

LoadedCloud usable_cloud(PointCloud cloud, CloudFormat format) {
  LoadedCloud loaded;
  loaded.cloud = std::move(cloud);
  SanitizeReport report = sanitize(loaded.cloud);
  if (has_empty_points(format)) report.dropped_positions = 0;
  loaded.warnings = warnings_of(report);
  estimate_unknown_radii(loaded.cloud);
  return loaded;
}

}  // namespace pointreel
