#include "codec/draco/draco_decode.h"

#include <exception>
#include <new>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include "common/base/concat.h"

namespace pointreel {
namespace {

/// The bytes without metadata, and without the flag that announces metadata.
Bytes without_metadata(ByteView bytes, const DrcHeader& header) {
  Bytes stripped(bytes.begin(), bytes.begin() + DrcHeader::kFixedSize);
  stripped[DrcHeader::kFixedSize - 1] &= 0x7f;
  stripped.insert(stripped.end(), bytes.begin() + static_cast<std::ptrdiff_t>(header.body),
                  bytes.end());
  return stripped;
}

}  // namespace

Result<std::unique_ptr<draco::PointCloud>> run_draco_decoder(ByteView bytes,
                                                             const DrcHeader& header,
                                                             const DecodeLimits& limits) {
  try {
    Bytes stripped;
    if (header.metadata) {
      stripped = without_metadata(bytes, header);
      bytes = stripped;
    }
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!decoded.ok()) {
      return fail(concat("Draco cannot decode the data (", decoded.status().error_msg_string(),
                         "): it is damaged"));
    }
    std::unique_ptr<draco::PointCloud> cloud = std::move(decoded).value();
    if (cloud->num_points() > limits.max_points) {
      return fail(ErrorCode::limit,
                  concat("the Draco data hold ", cloud->num_points(), " points, but at most ",
                         limits.max_points, " are accepted"));
    }
    return cloud;
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, "not enough memory to decode the Draco data");
  } catch (const std::exception& error) {
    return fail(concat("Draco cannot decode the data (", error.what(), ")"));
  }
}

bool is_readable(const draco::PointAttribute& attribute, std::uint32_t points) {
  const auto value_bytes = static_cast<std::int64_t>(attribute.num_components()) *
                           draco::DataTypeLength(attribute.data_type());
  if (attribute.num_components() == 0 || value_bytes <= 0 ||
      attribute.byte_stride() < value_bytes || attribute.byte_offset() < 0) {
    return false;
  }
  const std::uint64_t values = attribute.size();
  if (points == 0) return true;
  if (attribute.buffer() == nullptr || values == 0) return false;
  const std::uint64_t end = static_cast<std::uint64_t>(attribute.byte_offset()) +
                            (values - 1) * static_cast<std::uint64_t>(attribute.byte_stride()) +
                            static_cast<std::uint64_t>(value_bytes);
  if (end > attribute.buffer()->data_size()) return false;
  if (attribute.is_mapping_identity()) return points <= values;
  if (attribute.indices_map_size() < points) return false;
  for (std::uint32_t i = 0; i < points; ++i) {
    if (attribute.mapped_index(draco::PointIndex(i)).value() >= values) return false;
  }
  return true;
}

}  // namespace pointreel
