#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "codec/formats/format_table.h"
#include "pointreel/cloud.h"

namespace pointreel {

/// Reading any bytes gives a cloud whose parts fit together, or an error in one line. Returns how
/// many points there were.
inline std::size_t read_points(ByteView bytes, CloudFormat format) {
  const auto require = [](bool condition) {
    if (!condition) std::abort();
  };
  const auto one_line = [](const std::string& text) {
    return !text.empty() && text.find('\n') == std::string::npos;
  };
  const DecodeLimits limits{1u << 20, std::uint64_t{64} << 20};
  std::vector<std::string> unread;
  Result<PointCloud> cloud = read_points(ByteSource(bytes), format, limits, unread);
  if (!cloud) {
    require(one_line(cloud.error().message));
    return 0;
  }
  for (const std::string& name : unread) require(one_line(name));
  const std::size_t count = cloud->size();
  require(!cloud->has_normals() || cloud->normals.size() == count);
  require(!cloud->has_colors() || cloud->colors.size() == count);
  sanitize(*cloud);
  const Box box = bounds(*cloud);
  require(cloud->empty() || box.min.x <= box.max.x);
  return count;
}

}  // namespace pointreel
