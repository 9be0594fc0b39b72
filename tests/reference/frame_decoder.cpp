#include "tests/reference/frame_decoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <xxhash.h>
#include <zstd.h>

#include "codec/core/morton.h"
#include "common/base/try.h"
#include "pointreel/cloud.h"
#include "tests/reference/color_decoder.h"

namespace pointreel::reference {
namespace {

enum Coding : unsigned { none = 0, zstd = 1, context = 2 };

std::uint64_t number(ByteView bytes, std::size_t at, int size) {
  std::uint64_t value = 0;
  for (int i = size; i-- > 0;) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
  return value;
}

double real(ByteView bytes, std::size_t at) { return std::bit_cast<double>(number(bytes, at, 8)); }

std::uint64_t checksum(ByteView header, ByteView payload) {
  return XXH3_64bits_withSeed(payload.data(), payload.size(),
                              XXH3_64bits(header.data(), header.size()));
}

struct Header {
  int depth, layers;
  unsigned flags;
  std::uint64_t points, tag;
  glm::dvec3 corner;
  double edge;

  bool colors() const { return flags & 1; }
  bool normals() const { return flags & 2; }
  bool colors_16_bit() const { return flags & 4; }
  bool colors_transformed() const { return flags & 8; }
  bool normals_transformed() const { return flags & 16; }
};

int end_of_layer(int layer, int depth) {
  return layer == 0 ? std::min(7, depth) : layer == 1 ? std::min(9, depth) : depth;
}

Result<Header> read_header(ByteView bytes) {
  if (bytes.size() < 64) return fail("shorter than a header");
  if (number(bytes, 0, 4) != 0x46525250) return fail("magic");
  if (bytes[4] != 2) return fail("version");
  if (number(bytes, 56, 8) != checksum(bytes.first(56), {})) return fail("checksum of the header");
  if (bytes[5] != 1) return fail("codec");
  Header header;
  header.depth = bytes[6];
  header.flags = bytes[7];
  header.points = number(bytes, 12, 4);
  header.layers = static_cast<int>(number(bytes, 16, 4));
  header.tag = number(bytes, 20, 4);
  header.corner = {real(bytes, 24), real(bytes, 32), real(bytes, 40)};
  header.edge = real(bytes, 48);
  if (header.depth > 21 || (header.points == 0 && header.depth > 0)) return fail("depth");
  if (header.points > number(bytes, 8, 4) || header.points > 1u << 26) return fail("points");
  if (header.flags > 31 || (header.colors_transformed() && !header.colors()) ||
      (header.normals_transformed() && !header.normals())) {
    return fail("flags");
  }
  if (header.layers != (header.depth <= 7 ? 1 : header.depth <= 9 ? 2 : 3)) return fail("layers");
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(header.corner[axis])) return fail("corner");
  }
  if (!(header.edge >= 1e-30 && header.edge <= 1e30)) return fail("edge");
  return header;
}

struct Chunk {
  unsigned coding = 0;
  std::uint64_t raw_size = 0;
  ByteView payload;
};

Result<Chunk> read_chunk(ByteView bytes, unsigned kind, int layer, const Header& frame) {
  if (bytes.size() < 24) return fail("shorter than a chunk");
  if (number(bytes, 0, 2) != 0x4352) return fail("magic of a chunk");
  if (number(bytes, 16, 8) != checksum(bytes.first(16), bytes.subspan(24))) {
    return fail("checksum of a chunk");
  }
  if ((bytes[2] & 15u) != kind || bytes[3] != layer) return fail("another chunk");
  if (number(bytes, 4, 4) != frame.tag) return fail("tag");
  if (number(bytes, 8, 4) != static_cast<unsigned>(end_of_layer(layer, frame.depth))) {
    return fail("last level");
  }
  const Chunk chunk{unsigned{bytes[2]} >> 4, number(bytes, 12, 4), bytes.subspan(24)};
  if (chunk.coding > context) return fail("coding");
  return chunk;
}

/// The raw bytes of a chunk whose coding is none or zstd.
Result<Bytes> raw_bytes(const Chunk& chunk) {
  if (chunk.coding == none) {
    if (chunk.raw_size != chunk.payload.size()) return fail("raw size");
    return Bytes(chunk.payload.begin(), chunk.payload.end());
  }
  if (chunk.coding != zstd) return fail("coding");
  if (chunk.raw_size > 65536 + 1024 * chunk.payload.size()) return fail("expands too much");
  Bytes raw(chunk.raw_size);
  if (ZSTD_decompress(raw.data(), raw.size(), chunk.payload.data(), chunk.payload.size()) !=
      raw.size()) {
    return fail("zstd");
  }
  return raw;
}

using Cells = std::vector<glm::uvec3>;

/// The tree of the given layers: the cells of each level.
struct Tree {
  std::vector<Cells> levels;
  std::vector<int> layer_ends;
};

/// Adds the levels that these masks describe.
Result<void> grow(Tree& tree, const Bytes& masks, int last_level, std::uint64_t points) {
  std::size_t next = 0;
  while (static_cast<int>(tree.levels.size()) <= last_level) {
    Cells children;
    for (const glm::uvec3& cell : tree.levels.back()) {
      if (next == masks.size() || masks[next] == 0) return fail("masks");
      for (unsigned c = 0; c < 8; ++c) {
        if ((masks[next] >> c & 1) == 0) continue;
        children.push_back(2u * cell + glm::uvec3(c & 1, c >> 1 & 1, c >> 2));
      }
      ++next;
    }
    if (children.size() > points) return fail("more nodes than points");
    tree.levels.push_back(std::move(children));
  }
  return next == masks.size() ? Result<void>{} : fail("too many masks");
}

Result<Tree> read_tree(const Header& header, const std::vector<Chunks<ByteView>>& layers,
                       const Tables& tables) {
  Tree tree;
  std::vector<Bytes> raw;  // the masks of each layer
  std::vector<ContextLayer> contexts;
  for (int layer = 0; layer < header.layers; ++layer) {
    const auto at = static_cast<std::size_t>(layer);
    ByteView bytes = at < layers.size() ? layers[at].geometry : ByteView{};
    if (layer == 0) bytes = bytes.subspan(64);
    if (layer > 0 && bytes.empty()) break;
    const Chunk chunk = TRY(read_chunk(bytes, 0, layer, header));
    const int first = layer == 0 ? 0 : tree.layer_ends.back();
    tree.layer_ends.push_back(end_of_layer(layer, header.depth));
    if (layer > 0 && (chunk.coding == context) != !contexts.empty()) return fail("codings");
    if (chunk.raw_size > header.points * static_cast<unsigned>(tree.layer_ends.back() - first)) {
      return fail("more masks than the points allow");
    }
    if (chunk.coding == context) {
      if (chunk.raw_size > 65536 + 1024 * chunk.payload.size()) return fail("too many masks");
      contexts.push_back({chunk.payload, first, tree.layer_ends.back(), chunk.raw_size});
    } else {
      raw.push_back(TRY(raw_bytes(chunk)));
    }
  }
  if (!contexts.empty()) {
    const Bytes masks = TRY(decode_context_layers(contexts, tables));
    auto next = masks.begin();
    for (const ContextLayer& layer : contexts) {
      const auto begin = std::exchange(next, next + static_cast<std::ptrdiff_t>(layer.masks));
      raw.emplace_back(begin, next);
    }
  }
  tree.levels.push_back(header.points > 0 ? Cells{{0, 0, 0}} : Cells{});
  for (std::size_t layer = 0; layer < raw.size(); ++layer) {
    TRY(grow(tree, raw[layer], tree.layer_ends[layer], header.points));
  }
  if (tree.layer_ends.back() == header.depth && tree.levels.back().size() != header.points) {
    return fail("number of leaves");
  }
  return tree;
}

using Code = std::array<unsigned, 3>;

/// The codes of the leaves, with `components` components of `bits` bits; empty if the base layer
/// has none.
Result<std::vector<Code>> read_codes(const Header& header, const Tree& tree,
                                     const std::vector<Chunks<ByteView>>& layers, unsigned kind,
                                     std::size_t components, unsigned bits) {
  const auto part = kind == 1 ? &Chunks<ByteView>::colors : &Chunks<ByteView>::normals;
  std::vector<Code> codes;
  if ((layers.front().*part).empty()) return codes;
  std::map<std::uint64_t, Code> above;  // of the level at which the layer before ends
  for (std::size_t layer = 0; layer < tree.layer_ends.size(); ++layer) {
    const int level = tree.layer_ends[layer];
    const Cells& cells = tree.levels[static_cast<std::size_t>(level)];
    codes.assign(cells.size(), Code{});
    for (std::size_t i = 0; i < cells.size() && layer > 0; ++i) {
      codes[i] = above.at(morton_encode(cells[i] >> unsigned(level - tree.layer_ends[layer - 1])));
    }
    if (!(layers[layer].*part).empty()) {
      const Chunk chunk =
          TRY(read_chunk(layers[layer].*part, kind, static_cast<int>(layer), header));
      const Bytes raw = TRY(raw_bytes(chunk));
      if (raw.size() != cells.size() * components * (bits / 8)) return fail("size of codes");
      std::size_t next = 0;
      for (std::size_t k = 0; k < components; ++k) {
        for (unsigned shift = bits; shift > 0;) {
          shift -= 8;
          for (Code& code : codes) code[k] += unsigned{raw[next++]} << shift;
        }
        for (Code& code : codes) code[k] &= (1u << bits) - 1;
      }
    }
    above.clear();
    for (std::size_t i = 0; i < cells.size(); ++i) above[morton_encode(cells[i])] = codes[i];
  }
  return codes;
}

glm::u16vec3 color_of(const Code& code, unsigned bits) {
  const unsigned mask = (1u << bits) - 1, scale = bits == 8 ? 257 : 1;
  const unsigned green = code[0];
  return glm::u16vec3(scale *
                      glm::uvec3((green + code[1]) & mask, green, (green + code[2]) & mask));
}

glm::dvec3 normal_of(const Code& code) {
  if (code[0] == 255 || code[1] == 255) return glm::dvec3(0.0);
  const glm::dvec2 v(code[0] / 127.0 - 1.0, code[1] / 127.0 - 1.0);
  const double z = 1.0 - std::abs(v.x) - std::abs(v.y);
  if (z >= 0.0) return glm::normalize(glm::dvec3(v, z));
  return glm::normalize(glm::dvec3((1.0 - std::abs(v.y)) * (v.x < 0.0 ? -1.0 : 1.0),
                                   (1.0 - std::abs(v.x)) * (v.y < 0.0 ? -1.0 : 1.0), z));
}

/// The leaves' values of a transformed attribute; empty if the base layer has none.
Result<Values> read_values(const Header& header, const Tree& tree,
                           const std::vector<Chunks<ByteView>>& layers, unsigned kind) {
  const auto part = kind == 1 ? &Chunks<ByteView>::colors : &Chunks<ByteView>::normals;
  Values values;
  std::vector<Bytes> payloads;
  std::size_t have = 0;
  for (; have < tree.layer_ends.size() && !(layers[have].*part).empty(); ++have) {
    const Chunk chunk = TRY(read_chunk(layers[have].*part, kind, static_cast<int>(have), header));
    if (chunk.coding != none || chunk.raw_size != chunk.payload.size()) return fail("coding");
    payloads.emplace_back(chunk.payload.begin(), chunk.payload.end());
  }
  if (have == 0) return values;
  const int level = tree.layer_ends[have - 1];
  const Cells& cells = tree.levels[static_cast<std::size_t>(level)];
  const Values decoded = TRY(decode_values(cells, payloads, tree.layer_ends, kind == 2));
  std::map<std::uint64_t, glm::ivec3> by_cell;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    by_cell[morton_encode(cells[i])] = decoded.nodes[i];
  }
  values.exact = decoded.exact;
  for (const glm::uvec3& leaf : tree.levels.back()) {
    values.nodes.push_back(
        by_cell.at(morton_encode(leaf >> unsigned(tree.layer_ends.back() - level))));
  }
  return values;
}

glm::dvec3 normal_of(const glm::ivec3& value) {
  const double length = glm::length(glm::dvec3(value));
  return length < 2040.0 ? glm::dvec3(0.0) : glm::dvec3(value) / length;
}

Result<void> read_attributes(const Header& header, const Tree& tree,
                             const std::vector<Chunks<ByteView>>& layers, Frame& frame) {
  const int bits = header.colors_16_bit() ? 16 : 8;
  if (header.colors_transformed()) {
    const Values values = TRY(read_values(header, tree, layers, 1));
    if (values.exact && bits == 16) return fail("exact colours of 16 bits");
    for (const glm::ivec3& value : values.nodes) {
      frame.colors.push_back(values.exact ? color_of_exact_value(value)
                                          : color_of_value(value, bits));
    }
  } else if (header.colors()) {
    const auto width = static_cast<unsigned>(bits);
    const auto codes = TRY(read_codes(header, tree, layers, 1, 3, width));
    for (const Code& code : codes) frame.colors.push_back(color_of(code, width));
  }
  if (header.normals_transformed()) {
    const Values values = TRY(read_values(header, tree, layers, 2));
    if (values.exact) return fail("exact normals");
    for (const glm::ivec3& value : values.nodes) frame.normals.push_back(normal_of(value));
  } else if (header.normals()) {
    const auto codes = TRY(read_codes(header, tree, layers, 2, 2, 8));
    for (const Code& code : codes) frame.normals.push_back(normal_of(code));
  }
  return {};
}

/// Takes bytes from the front, or fails.
class Cursor {
 public:
  explicit Cursor(ByteView bytes) : rest_(bytes) {}

  Result<ByteView> take(std::uint64_t size) {
    if (size > rest_.size()) return fail("scalar fields are cut short");
    const ByteView taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  ByteView rest_;
};

Result<void> read_scalars(const Header& header, const Tree& tree,
                          const std::vector<Chunks<ByteView>>& layers, Frame& frame) {
  const auto layer = static_cast<std::size_t>(header.layers);
  if (layers.size() <= layer || layers[layer].geometry.empty()) return {};
  const Chunk chunk = TRY(read_chunk(layers[layer].geometry, 3, header.layers, header));
  if (chunk.coding != none || chunk.raw_size != chunk.payload.size()) return fail("coding");
  struct Entry {
    unsigned flags;
    double offset, step;
    std::vector<std::uint64_t> sizes;
  };
  std::vector<Entry> entries;
  Cursor cursor(chunk.payload);
  const std::uint64_t count = number(TRY(cursor.take(1)), 0, 1);
  if (count < 1 || count > 8) return fail("number of fields");
  for (std::uint64_t i = 0; i < count; ++i) {
    const ByteView fixed = TRY(cursor.take(18));
    Entry entry{fixed[0], real(fixed, 1), real(fixed, 9), {}};
    const ByteView text = TRY(cursor.take(fixed[17]));
    Scalar scalar{{text.begin(), text.end()}, {}};
    for (std::size_t k = 0; k < layer; ++k)
      entry.sizes.push_back(number(TRY(cursor.take(4)), 0, 4));
    if (entry.flags > 3 || !std::isfinite(entry.offset) || !std::isfinite(entry.step) ||
        !(entry.step > 0.0) || !is_scalar_name(scalar.name)) {
      return fail("entry of a field");
    }
    for (const Scalar& other : frame.scalars)
      if (other.name == scalar.name) return fail("two fields of one name");
    entries.push_back(std::move(entry));
    frame.scalars.push_back(std::move(scalar));
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    std::vector<Bytes> streams;
    for (const std::uint64_t size : entries[i].sizes) {
      const ByteView bytes = TRY(cursor.take(size));
      streams.emplace_back(bytes.begin(), bytes.end());
    }
    const Values values = TRY(decode_values(tree.levels.back(), streams, tree.layer_ends, false));
    if (!values.exact) return fail("inexact scalars");
    for (const glm::ivec3& value : values.nodes) {
      const double known = entries[i].offset + entries[i].step * (value.x + 16384);
      constexpr double kMost = std::numeric_limits<float>::max();
      const bool unknown = (entries[i].flags & 2) != 0 && value.y != 0;
      frame.scalars[i].values.push_back(unknown
                                            ? std::numeric_limits<float>::quiet_NaN()
                                            : static_cast<float>(std::clamp(known, -kMost, kMost)));
    }
  }
  if (!cursor.at_end()) return fail("bytes behind the scalar fields");
  return {};
}

}  // namespace

Result<Frame> decode_frame(const std::vector<Chunks<ByteView>>& layers, const Tables& tables) {
  if (layers.empty()) return fail("no layers");
  const Header header = TRY(read_header(layers.front().geometry));
  const Tree tree = TRY(read_tree(header, layers, tables));
  Frame frame;
  frame.depth = tree.layer_ends.back();
  frame.cells = tree.levels.back();
  frame.corner = header.corner;
  frame.edge = header.edge;
  TRY(read_attributes(header, tree, layers, frame));
  TRY(read_scalars(header, tree, layers, frame));
  return frame;
}

}  // namespace pointreel::reference
