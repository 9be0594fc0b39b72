#pragma once

#include <memory>

#include <draco/point_cloud/point_cloud.h>

#include "codec/draco/drc_header.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// What the package codec and the reader of user files share: Draco's decoder behind our errors.
namespace pointreel {

/// Runs Draco on bytes whose header has been parsed and accepted, without their metadata. Draco's
/// exceptions (no memory) become errors; the result has no more points than `limits`.
Result<std::unique_ptr<draco::PointCloud>> run_draco_decoder(ByteView bytes,
                                                             const DrcHeader& header,
                                                             const DecodeLimits& limits);

/// True if every point maps to a value that lies in the attribute's buffer.
bool is_readable(const draco::PointAttribute& attribute, std::uint32_t points);

}  // namespace pointreel
