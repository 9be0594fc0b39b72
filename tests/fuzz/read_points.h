#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "codec/files/format_table.h"
#include "pointreel/cloud.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz {

/// Reading any bytes gives a cloud whose parts fit together, or an error in one line. Returns how
/// many points there were.
inline std::size_t read_points(ByteView bytes, CloudFormat format, const Reading& reading = {}) {
  const DecodeLimits limits{1u << 20, std::uint64_t{64} << 20};
  ReadNotes notes;
  Result<PointCloud> cloud = read_points(ByteSource(bytes), format, limits, reading, notes);
  if (!cloud) {
    require(one_line(cloud.error().message));
    return 0;
  }
  for (const std::string& name : notes.unread) require(one_line(name));
  for (const std::string& line : notes.warnings) require(one_line(line));
  const std::size_t count = cloud->size();
  require(!cloud->has_normals() || cloud->normals.size() == count);
  require(!cloud->has_colors() || cloud->colors.size() == count);
  sanitize(*cloud);
  const Box box = bounds(*cloud);
  require(cloud->empty() || box.min.x <= box.max.x);
  return count;
}

}  // namespace pointreel::fuzz
