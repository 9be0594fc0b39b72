#include "tests/reference/video_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>

#include <xxhash.h>

#include "codec/video/av1_decoder.h"
#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "tests/reference/frame_decoder.h"
#include "tests/reference/symbol_reader.h"

namespace pointreel::reference {
namespace {

/// A plane of numbers, row by row.
struct Plane {
  int width = 0, height = 0;
  std::vector<int> values;

  Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w * h)) {}
  int& at(int x, int y) { return values[static_cast<std::size_t>(y * width + x)]; }
  int at(int x, int y) const { return values[static_cast<std::size_t>(y * width + x)]; }
};

/// Places and sizes in pixels.
struct PatchFields {
  int view, layer;
  int left, top;  ///< in the view
  int width, height;
  int picture_left, picture_top;
};

struct ViewDepth {
  double begin, steps;
  int two_pixels;  ///< in values of depth
};

struct GroupFields {
  bool colors;
  int frames;
  glm::dvec3 origin;
  double pitch;
  int width, height;  ///< of the pictures, in pixels
  std::array<ViewDepth, 6> views;
  std::vector<PatchFields> patches;
};

int get_u8(ByteReader& reader) { return reader.get<std::uint8_t>(); }
int get_u16(ByteReader& reader) { return reader.get<std::uint16_t>(); }

bool is_within(double value, double least, double most) { return value >= least && value <= most; }

PatchFields read_patch(ByteReader& reader) {
  PatchFields patch{};
  patch.view = get_u8(reader);
  patch.layer = get_u8(reader);
  patch.left = 16 * get_u16(reader);
  patch.top = 16 * get_u16(reader);
  patch.width = 16 * get_u16(reader);
  patch.height = 16 * get_u16(reader);
  patch.picture_left = 16 * get_u16(reader);
  patch.picture_top = 16 * get_u16(reader);
  return patch;
}

/// Marks the pixels of each patch in the pictures. Fails if a patch is none, lies outside, or
/// overlaps another.
Result<void> check_patches(const GroupFields& group) {
  Plane taken(group.width, group.height);
  for (const PatchFields& patch : group.patches) {
    if (patch.view > 5 || patch.layer > 3) return fail("view or layer of a patch");
    if (patch.width == 0 || patch.height == 0) return fail("size of a patch");
    if (patch.left + patch.width > 4096 || patch.top + patch.height > 4096) {
      return fail("a patch is outside of its view");
    }
    if (patch.picture_left + patch.width > group.width ||
        patch.picture_top + patch.height > group.height) {
      return fail("a patch is outside of the pictures");
    }
    for (int y = patch.picture_top; y < patch.picture_top + patch.height; ++y) {
      for (int x = patch.picture_left; x < patch.picture_left + patch.width; ++x) {
        if (taken.at(x, y)) return fail("patches overlap");
        taken.at(x, y) = 1;
      }
    }
  }
  return {};
}

Result<GroupFields> read_group(ByteView bytes) {
  ByteReader reader(bytes);
  GroupFields group{};
  if (get_u8(reader) != 1) return fail("version of the group");
  const int colors = get_u8(reader);
  if (colors > 1) return fail("whether frames have colours");
  group.colors = colors == 1;
  group.frames = get_u16(reader);
  if (group.frames < 1 || group.frames > 64) return fail("number of frames");
  for (int axis = 0; axis < 3; ++axis) {
    group.origin[axis] = reader.get<double>();
    if (!std::isfinite(group.origin[axis])) return fail("origin");
  }
  group.pitch = reader.get<double>();
  if (!is_within(group.pitch, 1e-30, 1e30)) return fail("pitch");
  group.width = 16 * get_u16(reader);
  group.height = 16 * get_u16(reader);
  if (!is_within(group.width, 16, 16 * 256) || !is_within(group.height, 16, 16 * 256)) {
    return fail("size of the pictures");
  }
  for (ViewDepth& view : group.views) {
    view.begin = reader.get<float>();
    const float steps = reader.get<float>();
    if (!is_within(view.begin, -8192.0, 8192.0) || !(steps > 0.001f && steps < 1000.0f)) {
      return fail("depths");
    }
    view.steps = steps;
    view.two_pixels = static_cast<int>(std::floor(2.0f * steps + 0.001f));
  }
  const int patches = get_u8(reader);
  if (patches > 24) return fail("number of patches");
  for (int i = 0; i < patches; ++i) group.patches.push_back(read_patch(reader));
  if (!reader.ok() || !reader.rest().empty()) return fail("bytes of the group");
  TRY(check_patches(group));
  return group;
}

/// The flags of the blocks of a patch. Blocks outside of it are off.
class PatchBlocks {
 public:
  PatchBlocks(const PatchFields& patch, Plane& blocks) : patch_(&patch), blocks_(&blocks) {}

  int columns() const { return patch_->width / 4; }
  int rows() const { return patch_->height / 4; }
  unsigned on(int x, int y) const {
    if (x < 0 || y < 0 || x >= columns() || y >= rows()) return 0;
    return static_cast<unsigned>(blocks_->at(patch_->picture_left / 4 + x,  //
                                             patch_->picture_top / 4 + y));
  }
  void set(int x, int y, int on) {
    blocks_->at(patch_->picture_left / 4 + x, patch_->picture_top / 4 + y) = on;
  }

 private:
  const PatchFields* patch_;
  Plane* blocks_;
};

/// The context of the four blocks whose left top one is (x, y).
unsigned context_of(const PatchBlocks& now, const PatchBlocks& before, int x, int y) {
  return before.on(x, y) << 0 | before.on(x + 1, y) << 1 |          //
         before.on(x, y + 1) << 2 | before.on(x + 1, y + 1) << 3 |  //
         now.on(x - 1, y) << 4 | now.on(x - 1, y + 1) << 5 |        //
         now.on(x, y - 1) << 6 | now.on(x + 1, y - 1) << 7 |        //
         now.on(x - 1, y - 1) << 8 | now.on(x + 2, y - 1) << 9;
}

/// Decodes the blocks of a frame. `before`: those of the frame before, all off in the first frame.
Result<Plane> read_occupancy(ByteView bytes, const GroupFields& group, Plane& before,
                             std::vector<Alphabet>& alphabets) {
  SymbolReader reader(bytes);
  Plane blocks(group.width / 4, group.height / 4);
  for (const PatchFields& patch : group.patches) {
    PatchBlocks now(patch, blocks);
    const PatchBlocks then(patch, before);
    for (int y = 0; y < now.rows(); y += 2) {
      for (int x = 0; x < now.columns(); x += 2) {
        Alphabet& alphabet = alphabets[context_of(now, then, x, y)];
        const int symbol = reader.symbol(x / 2 % 2, alphabet);
        now.set(x, y, symbol & 1);
        now.set(x + 1, y, symbol >> 1 & 1);
        now.set(x, y + 1, symbol >> 2 & 1);
        now.set(x + 1, y + 1, symbol >> 3 & 1);
      }
    }
  }
  if (!reader.complete()) return fail("occupancy");
  return blocks;
}

/// The flags of the blocks of a patch, interpolated linearly at the centre of the pixel (x, y) of
/// the patch.
double interpolated_flag(const PatchBlocks& blocks, int x, int y) {
  // A pixel's centre, where the centre of the first block is 0 and that of the second is 1.
  const double right = (x + 0.5 - 2.0) / 4.0, down = (y + 0.5 - 2.0) / 4.0;
  const int left = static_cast<int>(std::floor(right)), top = static_cast<int>(std::floor(down));
  double sum = 0.0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double weight = (1.0 - std::abs(right - left - i)) * (1.0 - std::abs(down - top - j));
      sum += weight * blocks.on(std::clamp(left + i, 0, blocks.columns() - 1),
                                std::clamp(top + j, 0, blocks.rows() - 1));
    }
  }
  return sum;
}

constexpr int kNoPoint = -1;

/// The values of depth of the pixels of a patch, kNoPoint where the blocks have no point.
Plane depths_of_patch(const PatchFields& patch, Plane& blocks, const Av1Picture& picture) {
  const PatchBlocks flags(patch, blocks);
  Plane depths(patch.width, patch.height);
  for (int y = 0; y < patch.height; ++y) {
    for (int x = 0; x < patch.width; ++x) {
      const bool on = interpolated_flag(flags, x, y) >= 0.5;
      depths.at(x, y) =
          on ? *picture.depth.from(patch.picture_left + x, patch.picture_top + y) : kNoPoint;
    }
  }
  return depths;
}

/// A neighbour of a pixel on the same surface.
struct Neighbor {
  int i, j;  ///< its place to the right and down, from the pixel
  int rise;  ///< how much larger its depth is, in values
};

/// Those of the eight neighbours of a point in its patch that have a point, and whose depth differs
/// by at most two pixels.
std::vector<Neighbor> neighbors_of(const Plane& depths, int x, int y, const ViewDepth& view) {
  std::vector<Neighbor> near;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      if (i == 0 && j == 0) continue;
      if (x + i < 0 || y + j < 0 || x + i >= depths.width || y + j >= depths.height) continue;
      const int depth = depths.at(x + i, y + j);
      const int rise = depth - depths.at(x, y);
      if (depth != kNoPoint && std::abs(rise) <= view.two_pixels) near.push_back({i, j, rise});
    }
  }
  return near;
}

/// The same depths without the points that fewer than three neighbours support.
Plane supported_depths(const Plane& depths, const ViewDepth& view) {
  Plane supported = depths;
  for (int y = 0; y < depths.height; ++y) {
    for (int x = 0; x < depths.width; ++x) {
      if (depths.at(x, y) == kNoPoint) continue;
      if (neighbors_of(depths, x, y, view).size() < 3) supported.at(x, y) = kNoPoint;
    }
  }
  return supported;
}

/// The axes of a view, 0 for x to 2 for z.
struct Axes {
  int right, down, depth;
};

Axes axes_of(int view) {
  if (view < 2) return {2, 1, 0};
  if (view < 4) return {0, 2, 1};
  return {0, 1, 2};
}

/// The normal of a point, from the points that are not left out.
glm::dvec3 normal_at(const Plane& depths, int x, int y, int view, const ViewDepth& view_depth) {
  double rise_right = 0.0, rise_down = 0.0;
  int right = 0, down = 0;
  for (const Neighbor& neighbor : neighbors_of(depths, x, y, view_depth)) {
    rise_right += neighbor.i * neighbor.rise / view_depth.steps;
    rise_down += neighbor.j * neighbor.rise / view_depth.steps;
    right += neighbor.i != 0;
    down += neighbor.j != 0;
  }
  const double facing = view % 2 == 0 ? 1.0 : -1.0;
  const Axes axes = axes_of(view);
  glm::dvec3 normal;
  normal[axes.right] = -facing * rise_right / std::max(right, 1);
  normal[axes.down] = -facing * rise_down / std::max(down, 1);
  normal[axes.depth] = facing;
  return glm::normalize(normal);
}

/// The point of the pixel (u, v) of a view whose depth has this value.
glm::dvec3 place_of(const GroupFields& group, int view, int u, int v, int depth) {
  const ViewDepth& view_depth = group.views[static_cast<std::size_t>(view)];
  const Axes axes = axes_of(view);
  glm::dvec3 place;
  place[axes.right] = u + 0.5;
  place[axes.down] = v + 0.5;
  place[axes.depth] = view_depth.begin + depth / view_depth.steps;
  return group.origin + group.pitch * place;
}

/// A component of a colour from luma and what chroma adds to it, in steps of 1/64.
std::uint16_t component(int luma, double chroma) {
  const int value = (64 * luma + 32 + static_cast<int>(chroma)) >> 6;
  return static_cast<std::uint16_t>(257 * std::clamp(value, 0, 255));
}

/// The colour at (x, y) of the pictures.
glm::u16vec3 color_at(const Av1Picture& picture, int x, int y) {
  const int luma = *picture.luma.from(x, y);
  const int cb = *picture.cb.from(x / 2, y / 2) - 128, cr = *picture.cr.from(x / 2, y / 2) - 128;
  const double red = std::round(64 * 1.5748 * cr);
  const double green = std::round(-64 * 0.2126 * 1.5748 / 0.7152 * cr) +
                       std::round(-64 * 0.0722 * 1.8556 / 0.7152 * cb);
  const double blue = std::round(64 * 1.8556 * cb);
  return {component(luma, red), component(luma, green), component(luma, blue)};
}

/// Adds the points that the pictures show. `colors`: null if the frame has none.
void add_points_of_pictures(const GroupFields& group, Plane& blocks, const Av1Picture& depth,
                            const Av1Picture* colors, VideoPoints& points) {
  for (const PatchFields& patch : group.patches) {
    const ViewDepth& view = group.views[static_cast<std::size_t>(patch.view)];
    const Plane depths = supported_depths(depths_of_patch(patch, blocks, depth), view);
    for (int y = 0; y < patch.height; ++y) {
      for (int x = 0; x < patch.width; ++x) {
        if (depths.at(x, y) == kNoPoint) continue;
        points.positions.push_back(
            place_of(group, patch.view, patch.left + x, patch.top + y, depths.at(x, y)));
        points.normals.push_back(normal_at(depths, x, y, patch.view, view));
        if (colors != nullptr) {
          points.colors.push_back(color_at(*colors, patch.picture_left + x, patch.picture_top + y));
        }
      }
    }
  }
}

/// Takes bytes from the front, or fails.
Result<ByteView> take(ByteView& bytes, std::size_t size) {
  if (size > bytes.size()) return fail("cut short");
  const ByteView taken = bytes.first(size);
  bytes = bytes.subspan(size);
  return taken;
}

Result<ByteView> take_sized(ByteView& bytes) {
  ByteReader size(TRY(take(bytes, 4)));
  return take(bytes, size.get<std::uint32_t>());
}

/// Adds the points that no picture shows. `colors`: whether the points of the pictures have
/// colours.
Result<void> add_leftovers(ByteView bytes, bool colors, const Tables& tables, VideoPoints& points) {
  if (bytes.empty()) return {};
  std::vector<Chunks<ByteView>> layers;
  while (!bytes.empty()) {
    Chunks<ByteView>& layer = layers.emplace_back();
    layer.geometry = TRY(take_sized(bytes));
    layer.colors = TRY(take_sized(bytes));
    if (layers.size() > 3) return fail("layers of the leftovers");
  }
  const Frame frame = TRY(decode_frame(layers, tables));
  const double cell = frame.edge / static_cast<double>(1 << frame.depth);
  for (const glm::uvec3& leaf : frame.cells) {
    points.positions.push_back(frame.corner + (glm::dvec3(leaf) + 0.5) * cell);
    points.normals.emplace_back(0.0);
  }
  if (!colors) return {};
  points.colors.insert(points.colors.end(), frame.colors.begin(), frame.colors.end());
  points.colors.resize(points.positions.size(), glm::u16vec3(0));
  return {};
}

struct VideoChunk {
  unsigned frame = 0;
  ByteView payload;
};

Result<VideoChunk> read_video_chunk(ByteView bytes, int kind) {
  ByteView payload = bytes;
  const ByteView header = TRY(take(payload, 24));
  ByteReader reader(header);
  VideoChunk chunk;
  if (get_u16(reader) != 0x4352) return fail("magic of a chunk");
  if (get_u8(reader) != kind) return fail("another chunk");
  if (get_u8(reader) != 1) return fail("layer of a chunk");
  chunk.frame = reader.get<std::uint32_t>();
  if (reader.get<std::uint32_t>() != 0) return fail("last level");
  if (reader.get<std::uint32_t>() != payload.size()) return fail("raw size");
  const XXH64_hash_t seed = XXH3_64bits(header.data(), 16);
  if (reader.get<std::uint64_t>() != XXH3_64bits_withSeed(payload.data(), payload.size(), seed)) {
    return fail("checksum of a chunk");
  }
  chunk.payload = payload;
  return chunk;
}

/// The parts of the payload of a geometry chunk.
struct GeometryParts {
  ByteView group, occupancy, leftovers, depth;
};

Result<GeometryParts> split_geometry(ByteView payload) {
  ByteReader sizes(TRY(take(payload, 12)));
  GeometryParts parts;
  parts.group = TRY(take(payload, sizes.get<std::uint32_t>()));
  parts.occupancy = TRY(take(payload, sizes.get<std::uint32_t>()));
  parts.leftovers = TRY(take(payload, sizes.get<std::uint32_t>()));
  parts.depth = payload;
  return parts;
}

}  // namespace

/// What carries over from frame to frame.
struct VideoDecoder::Group {
  GroupFields fields;
  unsigned next_frame = 0;
  Plane blocks_before;
  std::vector<Alphabet> alphabets;
  Av1Decoder depth;
  std::optional<Av1Decoder> colors;  ///< none if there are no colours, or some were left out

  static Result<std::unique_ptr<Group>> open(ByteView bytes);
  Result<VideoPoints> next(const GeometryParts& geometry, ByteView color_chunk,
                           const Tables& tables);
};

Result<std::unique_ptr<VideoDecoder::Group>> VideoDecoder::Group::open(ByteView bytes) {
  GroupFields fields = TRY(read_group(bytes));
  Av1Decoder depth = TRY(Av1Decoder::open({fields.width, fields.height, 10}));
  std::optional<Av1Decoder> colors;
  if (fields.colors) colors = TRY(Av1Decoder::open({fields.width, fields.height, 8}));
  const Plane blocks(fields.width / 4, fields.height / 4);
  return std::make_unique<Group>(Group{std::move(fields), 0, blocks,
                                       std::vector<Alphabet>(1024, Alphabet(16, 16)),
                                       std::move(depth), std::move(colors)});
}

Result<VideoPoints> VideoDecoder::Group::next(const GeometryParts& geometry, ByteView color_chunk,
                                              const Tables& tables) {
  const unsigned frame = next_frame++;
  Plane blocks = TRY(read_occupancy(geometry.occupancy, fields, blocks_before, alphabets));
  const Av1Picture depth_picture = TRY(depth.decode(geometry.depth));
  std::optional<Av1Picture> color_picture;
  VideoChunk color;
  if (!color_chunk.empty()) {
    color = TRY(read_video_chunk(color_chunk, 1));
    if (color.frame != frame) return fail("colours of another frame");
  }
  if (color.payload.empty()) colors.reset();
  if (colors) color_picture = TRY(colors->decode(color.payload));
  VideoPoints points;
  add_points_of_pictures(fields, blocks, depth_picture, color_picture ? &*color_picture : nullptr,
                         points);
  TRY(add_leftovers(geometry.leftovers, color_picture.has_value(), tables, points));
  blocks_before = blocks;
  return points;
}

VideoDecoder::VideoDecoder(const Tables& tables) : tables_(tables) {}
VideoDecoder::VideoDecoder(VideoDecoder&&) noexcept = default;
VideoDecoder& VideoDecoder::operator=(VideoDecoder&&) noexcept = default;
VideoDecoder::~VideoDecoder() = default;

Result<VideoPoints> VideoDecoder::next(const Chunks<ByteView>& chunks) {
  // Without its group, the decoder is ready for the first frame of another one after an error.
  std::unique_ptr<Group> group = std::move(group_);
  const VideoChunk chunk = TRY(read_video_chunk(chunks.geometry, 0));
  const GeometryParts parts = TRY(split_geometry(chunk.payload));
  if (chunk.frame == 0) {
    group = TRY(Group::open(parts.group));
  } else {
    if (!group || chunk.frame != group->next_frame) return fail("not the next frame");
    if (!parts.group.empty()) return fail("a group begins in its middle");
  }
  if (chunk.frame >= static_cast<unsigned>(group->fields.frames)) return fail("too many frames");
  VideoPoints points = TRY(group->next(parts, chunks.colors, tables_));
  group_ = std::move(group);
  return points;
}

}  // namespace pointreel::reference
