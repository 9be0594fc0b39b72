#pragma once

#include <memory>

#include <draco/point_cloud/point_cloud.h>

#include "codec/draco/drc_header.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// Draco's decoder behind our errors, for frames and for the files of users.
namespace pointreel {

/// Runs Draco on bytes whose header has been parsed and accepted, without their metadata.
/// Exceptions, such as for lack of memory, become errors. The result has no more points, and took
/// no more memory, than `limits` allow; that includes a PointCloud made of it.
Result<std::unique_ptr<draco::PointCloud>> run_draco_decoder(ByteView bytes,
                                                             const DrcHeader& header,
                                                             const DecodeLimits& limits);

/// True if the values of all points are inside the attribute's buffer.
bool is_readable(const draco::PointAttribute& attribute, std::uint32_t points);

}  // namespace pointreel
