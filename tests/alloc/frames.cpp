#include "tests/alloc/frames.h"

#include <array>
#include <cmath>
#include <memory>
#include <random>

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include "codec/draco/drc_reader.h"
#include "common/base/try.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace {

/// A bent sheet with colours and normals.
PointCloud sheet(int side) {
  PointCloud cloud;
  const auto n = static_cast<float>(side);
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const glm::vec3 p(static_cast<float>(i) / n, static_cast<float>(j) / n,
                        0.5f + 0.4f * std::sin(static_cast<float>(i + j) / n));
      cloud.positions.push_back(p);
      cloud.normals.push_back(glm::normalize(p - glm::vec3(0.5f, 0.5f, -1.0f)));
      cloud.colors.push_back(glm::u16vec3(i * 31 % 256, j * 17 % 256, (i + j) % 256) *
                             std::uint16_t{257});
    }
  }
  return cloud;
}

/// A solid cube, of which a context coder needs next to no bytes for each point.
PointCloud solid(int side) {
  PointCloud cloud;
  for (int i = 0; i < side * side * side; ++i) {
    cloud.positions.push_back((glm::vec3(i % side, i / side % side, i / side / side) + 0.5f) /
                              static_cast<float>(side));
  }
  return cloud;
}

/// Points as far from each other as they can be: every node has a row and a plane of its own.
PointCloud noise(int points) {
  PointCloud cloud;
  std::minstd_rand random(1);
  const auto one = [&] { return static_cast<float>(random() % 65536) / 65536.0f; };
  for (int i = 0; i < points; ++i) {
    const float x = one(), y = one();
    cloud.positions.emplace_back(x, y, one());
  }
  return cloud;
}

Decoding frame_decoding(std::string name, const PointCloud& cloud, const EncodeOptions& options,
                        bool inner_nodes = false) {
  const auto frame =
      std::make_shared<const EncodedFrame>(encode_frame(cloud, Cube{}, options).value());
  const auto views =
      std::make_shared<const std::vector<Chunks<ByteView>>>(layer_views(frame->layers));
  return {std::move(name), [=](const DecodeLimits& given) -> Result<std::size_t> {
            DecodeLimits limits = given;
            limits.inner_nodes = inner_nodes;
            limits.leaves = !inner_nodes;
            const DecodedFrame decoded = TRY(decode_frame(*views, limits));
            (void)frame;  // the views are of its bytes
            return inner_nodes ? decoded.svo->leaf_count() : decoded.cloud.size();
          }};
}

OctreeOptions octree(Entropy entropy, int depth, int quality, int slabs = 0) {
  OctreeOptions options;
  options.entropy = entropy;
  options.depth = DepthRule::fixed(depth);
  options.color_quality = options.normal_quality = quality;
  options.slabs = slabs;
  return options;
}

DracoOptions draco_frame(DracoMethod method) {
  DracoOptions options;
  options.method = method;
  return options;
}

/// A .drc file of a mesh whose faces cover the sheet.
Bytes mesh_file(const PointCloud& cloud, int side, int method) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(cloud.size()));
  const auto add = [&](draco::GeometryAttribute::Type type, const std::vector<glm::vec3>& values) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    const int id = mesh.AddAttribute(attribute, true, mesh.num_points());
    for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
      mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &values[i].x);
    }
  };
  add(draco::GeometryAttribute::POSITION, cloud.positions);
  add(draco::GeometryAttribute::NORMAL, cloud.normals);
  const auto corner = [&](int i, int j) {
    return draco::PointIndex(static_cast<std::uint32_t>(i * side + j));
  };
  for (int i = 0; i + 1 < side; ++i) {
    for (int j = 0; j + 1 < side; ++j) {
      mesh.AddFace({corner(i, j), corner(i + 1, j), corner(i, j + 1)});
      mesh.AddFace({corner(i, j + 1), corner(i + 1, j), corner(i + 1, j + 1)});
    }
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 11);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 8);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return Bytes(buffer.data(), buffer.data() + buffer.size());
}

Decoding file_decoding(std::string name, Bytes bytes) {
  return {std::move(name),
          [bytes = std::move(bytes)](const DecodeLimits& limits) -> Result<std::size_t> {
            return TRY(read_drc(bytes, limits)).size();
          }};
}

}  // namespace

std::vector<Decoding> all_decodings(int side) {
  const PointCloud cloud = sheet(side), cube = solid(std::min(side, 128));
  PointCloud bare = cloud;
  bare.colors.clear();
  bare.normals.clear();
  return {
      frame_decoding("octree none", cloud, {octree(Entropy::none, 10, 100)}),
      frame_decoding("octree zstd", cloud, {octree(Entropy::zstd, 10, 60)}),
      frame_decoding("octree context", cloud, {octree(Entropy::context, 10, 60)}),
      frame_decoding("octree context, nodes", cloud, {octree(Entropy::context, 10, 60)}, true),
      frame_decoding("octree exact, nodes", cloud, {octree(Entropy::zstd, 10, 100)}, true),
      frame_decoding("octree slabs", cloud, {octree(Entropy::context, 10, 60, 4)}),
      frame_decoding("octree context 12", cloud, {octree(Entropy::context, 12, 60)}),
      frame_decoding("octree slabs 16", cloud, {octree(Entropy::context, 12, 60, 16)}),
      frame_decoding("octree deep", cloud, {octree(Entropy::context, 18, 60)}),
      frame_decoding("octree deep, nodes", cloud, {octree(Entropy::zstd, 21, 60)}, true),
      frame_decoding("octree noise 9", noise(side * side), {octree(Entropy::context, 9, 60)}),
      frame_decoding("octree noise 12", noise(side * side), {octree(Entropy::context, 12, 60)}),
      frame_decoding("octree noise 15", noise(side * side), {octree(Entropy::context, 15, 60)}),
      frame_decoding("octree noise, slabs", noise(side * side),
                     {octree(Entropy::context, 13, 60, 16)}),
      frame_decoding("octree solid", cube, {octree(Entropy::context, 8, 60)}),
      frame_decoding("draco kd-tree", cloud, {draco_frame(DracoMethod::kd_tree)}),
      frame_decoding("draco sequential", cloud, {draco_frame(DracoMethod::sequential)}),
      frame_decoding("draco positions", bare, {draco_frame(DracoMethod::kd_tree)}),
      frame_decoding("draco solid", cube, {draco_frame(DracoMethod::kd_tree)}),
      file_decoding("edgebreaker file", mesh_file(cloud, side, draco::MESH_EDGEBREAKER_ENCODING)),
      file_decoding("mesh file", mesh_file(cloud, side, draco::MESH_SEQUENTIAL_ENCODING)),
  };
}

}  // namespace pointreel
