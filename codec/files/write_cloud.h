#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

/// Clouds as files of other programs, in world coordinates.
namespace pointreel {

/// The files that frames are unpacked to.
enum class PointsFormat : std::uint8_t { ply, pcd, las, npz };

/// ".ply", ".pcd", ".las" or ".npz".
const char* extension(PointsFormat format);

/// A binary PCD file, version 0.7, with the columns of point_records.h.
Bytes pcd_bytes(const PointCloud& cloud);

/// A LAS 1.2 file of point format 2, or 0 without colours, without normals. Of scalar fields,
/// "intensity", "return number" and "classification" are kept, rounded. Coordinates are rounded
/// to a power of ten that is at most 2^-26 of the longest extent. z points up in LAS, but the axes
/// stay as they are.
Bytes las_bytes(const PointCloud& cloud);

/// What a LAS file does not keep of a scalar field.
struct LostValues {
  std::string field;
  std::uint64_t values = 0;
  /// Values outside of these bounds, or unknown, become the nearest bound, or the first. Without
  /// bounds, the whole field is left out.
  std::optional<std::pair<int, int>> bounds;
};
/// What las_bytes() clips or leaves out, apart from rounding.
std::vector<LostValues> lost_in_las(const PointCloud& cloud);

/// numpy's uncompressed archive of arrays of N rows and 3 columns: "positions" (float64), and where
/// the cloud has them "colors" (uint16, sRGB) and "normals" (float32), and of
/// N values for each scalar field (float32), with "_" for what file names should not have. `limit`
/// from 4 GiB on. Sources: "numpy.lib.format", version 1.0; "APPNOTE.TXT - .ZIP File Format
/// Specification" 6.3.
Result<Bytes> npz_bytes(const PointCloud& cloud);

/// The bytes of a file of that format.
Result<Bytes> cloud_bytes(const PointCloud& cloud, PointsFormat format);

}  // namespace pointreel
