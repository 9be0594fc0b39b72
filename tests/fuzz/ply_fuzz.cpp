// Reading any bytes as PLY gives a cloud or an error. A cloud that was read must be the same after
// it is written and read again.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "codec/files/ply.h"
#include "tests/fuzz/target.h"

FUZZ_TARGET(ply) {
  const Result<PointCloud> cloud = read_ply(input);
  if (!cloud) {
    require(one_line(cloud.error().message));
    return;
  }
  require(cloud->size() <= input.size());
  require(!cloud->has_normals() || cloud->normals.size() == cloud->size());
  require(!cloud->has_colors() || cloud->colors.size() == cloud->size());
  require(!cloud->has_radii() || cloud->radii.size() == cloud->size());
  require(cloud->scalars.size() <= kMaxScalars);
  for (const ScalarField& field : cloud->scalars)
    require(is_scalar_name(field.name) && field.values.size() == cloud->size());
  const Result<PointCloud> again = read_ply(ply_bytes(*cloud));
  require(again.has_value() && again->size() == cloud->size() && again->colors == cloud->colors);
  require(again->has_normals() == cloud->has_normals() && again->has_radii() == cloud->has_radii());
  require(again->scalars.size() == cloud->scalars.size());
}
