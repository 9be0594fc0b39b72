#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "codec/cloud_file.h"
#include "codec/draco/drc_reader.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "common/cloud/ply.h"
#include "common/surface/normals.h"

namespace pointreel {
namespace {

bool begins_with(ByteView bytes, std::string_view text) {
  return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

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

Result<LoadedCloud> read_cloud(ByteView bytes, const DecodeLimits& limits) {
  LoadedCloud loaded;
  if (begins_with(bytes, "DRACO")) {
    loaded.cloud = TRY(read_drc(bytes, limits));
  } else if (begins_with(bytes, "ply")) {
    loaded.cloud = TRY(read_ply(bytes, &loaded.unread));
  } else if (bytes.empty()) {
    return fail("the file is empty");
  } else {
    return fail("neither a PLY nor a Draco file: it begins with neither \"ply\" nor \"DRACO\"");
  }
  loaded.warnings = warnings_of(sanitize(loaded.cloud));
  estimate_unknown_radii(loaded.cloud);
  return loaded;
}

}  // namespace pointreel
