#include "codec/draco/draco_decode.h"

#include <algorithm>
#include <optional>
#include <type_traits>
#include <utility>

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/point_cloud/point_cloud_kd_tree_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/mesh/mesh.h>

#include "codec/draco/guarded.h"
#include "codec/octree/memory_budget.h"
#include "common/base/concat.h"
#include "common/base/try.h"

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

/// For each point: the map of its values, and the cloud that callers make of the result. That a
/// point counts for at least as much bounds the time of points with few attributes.
constexpr std::uint64_t kPointBytes = 64;

/// Draco 1.5.5 believes any number of orientations of texture coordinates in edgebreaker meshes:
/// up to 2^31 of them, which take 256 MiB and ten seconds. They count for that time.
constexpr std::uint64_t kOrientationBytes = std::uint64_t{512} << 20;

/// Takes the memory for the values of all points, as they are coded and as they are.
Result<void> take_attributes(const draco::PointCloud& cloud, bool edgebreaker,
                             const DecodeLimits& limits, MemoryBudget& budget) {
  if (cloud.num_points() > limits.max_points) {
    return fail(ErrorCode::limit,
                concat("the Draco data hold ", cloud.num_points(), " points, but at most ",
                       limits.max_points, " are accepted"));
  }
  std::uint64_t bytes = kPointBytes;
  for (int i = 0; i < cloud.num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *cloud.attribute(i);
    const int value = std::max(draco::DataTypeLength(attribute.data_type()), 1);
    bytes += 4 + attribute.num_components() * (static_cast<std::uint64_t>(value) + 4);
    if (edgebreaker && attribute.attribute_type() == draco::GeometryAttribute::TEX_COORD) {
      TRY(budget.take(1, kOrientationBytes));
    }
  }
  return budget.take(cloud.num_points(), bytes);
}

/// Takes the memory for the faces of a mesh: corners, and for edgebreaker their opposites, what
/// attributes with seams add to them, and the order in which they are visited.
Result<void> take_faces(const DrcHeader& header, MemoryBudget& budget) {
  if (!header.mesh) return {};
  if (header.method == 0) return budget.take(header.faces, 24);
  TRY(budget.take(header.points, 32));
  return budget.take(header.faces, 96 + 32 * std::uint64_t{header.seams});
}

/// One of Draco's decoders, stopped before it allocates the values of more points and attributes
/// than the budget allows. Their numbers are known only once the connectivity of a mesh is decoded.
template <class Decoder>
class Budgeted : public Decoder {
 public:
  Budgeted(const DecodeLimits& limits, MemoryBudget& budget) : limits_(limits), budget_(budget) {}

  const std::optional<Error>& refusal() const { return refusal_; }

 protected:
  bool DecodeAllAttributes() override {
    constexpr bool kEdgebreaker = std::is_same_v<Decoder, draco::MeshEdgebreakerDecoder>;
    const auto taken = take_attributes(*this->point_cloud(), kEdgebreaker, limits_, budget_);
    if (!taken) refusal_ = taken.error();
    return taken.has_value() && Decoder::DecodeAllAttributes();
  }

 private:
  const DecodeLimits& limits_;
  MemoryBudget& budget_;
  std::optional<Error> refusal_;
};

template <class Decoder, class Geometry>
Result<std::unique_ptr<draco::PointCloud>> run(ByteView bytes, const DecodeLimits& limits,
                                               MemoryBudget& budget) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto geometry = std::make_unique<Geometry>();
  Budgeted<Decoder> decoder(limits, budget);
  const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, geometry.get());
  if (decoder.refusal()) return tl::unexpected(*decoder.refusal());
  if (status.ok()) return geometry;
  return fail(
      concat("Draco cannot decode the data (", status.error_msg_string(), "): it is damaged"));
}

}  // namespace

Result<std::unique_ptr<draco::PointCloud>> run_draco_decoder(ByteView bytes,
                                                             const DrcHeader& header,
                                                             const DecodeLimits& limits) {
  MemoryBudget budget(limits.max_memory);
  TRY(take_faces(header, budget));
  using Decoded = Result<std::unique_ptr<draco::PointCloud>>;
  return guarded(
      "not enough memory to decode the Draco data", "Draco cannot decode the data",
      [&]() -> Decoded {
        Bytes stripped;
        if (header.metadata) {
          stripped = without_metadata(bytes, header);
          bytes = stripped;
        }
        if (header.mesh) {
          return header.method == 0
                     ? run<draco::MeshSequentialDecoder, draco::Mesh>(bytes, limits, budget)
                     : run<draco::MeshEdgebreakerDecoder, draco::Mesh>(bytes, limits, budget);
        }
        return header.method == 0
                   ? run<draco::PointCloudSequentialDecoder, draco::PointCloud>(bytes, limits,
                                                                                budget)
                   : run<draco::PointCloudKdTreeDecoder, draco::PointCloud>(bytes, limits, budget);
      });
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
