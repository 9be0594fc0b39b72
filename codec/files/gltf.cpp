#include "codec/files/gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "codec/core/json_fields.h"
#include "codec/files/glb_format.h"
#include "codec/files/numbers.h"
#include "codec/files/ply_header.h"
#include "codec/files/records.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Memory that a vertex takes while it is read, in bytes.
constexpr std::uint64_t kVertexMemory = 64;
/// Vertices of an accessor that has no buffer but only single vertices that differ from zero.
constexpr std::size_t kMostZeros = std::size_t{1} << 20;
/// Characters of meshes and materials that nodes show, again and again.
constexpr std::size_t kMostJsonRead = std::size_t{1} << 28;
/// Far deeper than any real scene, whose nodes are visited by recursion.
constexpr int kMostLevels = 100;

/// The parts of a file.
struct GlbChunks {
  ByteView json, binary;
};

Result<GlbChunks> chunks_of(ByteView bytes) {
  const auto at = [&](std::size_t offset) {
    return load_number<std::uint32_t>(bytes.data() + offset);
  };
  if (bytes.size() < 12 || at(0) != kGlbMagic) return GlbChunks{bytes, {}};
  if (at(4) != 2) {
    return fail(ErrorCode::unsupported,
                concat("byte 4: is of glTF version ", at(4), "; 2 can be read"));
  }
  GlbChunks chunks;
  std::size_t offset = 12;
  while (offset + 8 <= bytes.size()) {
    const std::size_t size = at(offset);
    const std::uint32_t type = at(offset + 4);
    offset += 8;
    const std::size_t rest = bytes.size() - offset, padding = -size % 4;
    // Some writers count padding that is not there.
    if (size > rest + 3) {
      return fail(concat("byte ", offset - 8, ": a chunk of ", size, " bytes ends after the file"));
    }
    const ByteView content = bytes.subspan(offset, std::min(size, rest));
    if (type == kGlbJson && chunks.json.empty()) chunks.json = content;
    if (type == kGlbBinary && chunks.binary.empty()) chunks.binary = content;
    offset += content.size();
    // Others leave padding out.
    const bool unpadded = offset + 8 <= bytes.size() && at(offset + 4) == kGlbBinary;
    if (!unpadded) offset += padding;
  }
  if (chunks.json.empty()) return fail("has no chunk of JSON");
  return chunks;
}

int digit_of(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

std::optional<Bytes> decode_base64(std::string_view text) {
  while (text.ends_with('=')) text.remove_suffix(1);
  Bytes bytes;
  bytes.reserve(text.size() * 3 / 4);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int digit = digit_of(c);
    if (digit < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::uint8_t>(bits >> count));
  }
  return bytes;
}

/// Numbers of each vertex, as an accessor describes them.
struct Accessor {
  ByteView bytes;          ///< from the first number on; empty if all are zero
  std::size_t stride = 0;  ///< from vertex to vertex
  std::size_t count = 0;
  std::size_t width = 1;  ///< numbers of a vertex
  NumberType type = NumberType::float32;
  double scale = 1.0;  ///< makes shares of normalised integers
  /// Vertices with other numbers than those.
  std::vector<std::pair<std::size_t, glm::dvec4>> others;
};

double clamped(double value, double scale) {
  return scale == 1.0 ? value : std::max(value * scale, -1.0);
}

glm::dvec4 numbers_at(const std::uint8_t* at, NumberType type, std::size_t width, double scale) {
  glm::dvec4 v(0.0, 0.0, 0.0, 1.0);
  with_number_type(type, [&](auto t) {
    using T = decltype(t);
    for (std::size_t i = 0; i < width; ++i)
      v[static_cast<int>(i)] =
          clamped(static_cast<double>(load_number<T>(at + i * sizeof(T))), scale);
  });
  return v;
}

double srgb_of(double linear) {
  linear = std::clamp(linear, 0.0, 1.0);
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Extensions that say nothing about where vertices are or what colours they have.
bool is_harmless_extension(std::string_view name) {
  for (const std::string_view begin :
       {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_",
        "EXT_lights_", "KHR_xmp", "KHR_animation_", "KHR_mesh_quantization"}) {
    if (name.starts_with(begin)) return true;
  }
  return false;
}

class GltfReader {
 public:
  GltfReader(JsonValue root, ByteView binary, const DecodeLimits& limits)
      : root_(root),
        binary_(binary),
        most_vertices_(
            std::min<std::uint64_t>(limits.max_points, limits.max_memory / kVertexMemory)) {}

  Result<PointCloud> read(ReadNotes& notes) {
    TRY(list_parts(notes.unread));
    TRY(read_buffers());
    if (scene_nodes_.empty() && nodes_.empty()) {
      for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh)
        TRY(add_mesh(mesh, glm::dmat4(1.0)));
    } else {
      shown_.resize(nodes_.size());
      for (const std::size_t node : scene_nodes_) TRY(add_node(node, glm::dmat4(1.0), 0));
    }
    notes.unread.insert(notes.unread.end(), dropped_.begin(), dropped_.end());
    return finish(notes);
  }

 private:
  using Parts = std::vector<JsonValue>;

  static Parts parts_of(const JsonValue* array) {
    Parts parts;
    if (array == nullptr) return parts;
    for (JsonItems item(*array); item.next();) parts.push_back(item.value());
    return parts;
  }

  Result<void> list_parts(std::vector<std::string>& unread) {
    Fields fields(root_);
    TRY(fields.check());
    const auto list = [&](const char* key) {
      return parts_of(fields.has(key) ? fields.value(key) : nullptr);
    };
    nodes_ = list("nodes");
    meshes_ = list("meshes");
    accessors_ = list("accessors");
    views_ = list("bufferViews");
    buffers_json_ = list("buffers");
    for (const char* key : {"textures", "skins", "animations"})
      if (!list(key).empty()) unread.push_back(key);
    materials_ = list("materials");
    for (const JsonValue& name : list("extensionsRequired")) {
      for (const char* packed : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}) {
        if (!is_text(name, packed)) continue;
        return fail(ErrorCode::unsupported,
                    concat("needs ", packed,
                           ", which is not read: export it without compression, "
                           "or convert it with \"gltf-transform copy IN OUT\""));
      }
      const std::string needed = TRY(name_of_extension(name));
      if (is_harmless_extension(needed)) continue;
      return fail(ErrorCode::unsupported, concat("needs the extension ", printable(needed),
                                                 ", which is not read: export it without"));
    }
    for (const JsonValue& name : list("extensionsUsed")) {
      const std::string used = TRY(name_of_extension(name));
      if (!is_harmless_extension(used)) unread.push_back(printable_name(used));
    }
    const Parts scenes = list("scenes");
    std::size_t shown = 0;
    if (fields.has("scene")) shown = fields.integer("scene", kMaxInteger);
    TRY(fields.check());
    if (scenes.empty()) {
      for (std::size_t i = 0; i < nodes_.size(); ++i) scene_nodes_.push_back(i);
      remove_children();
      return {};
    }
    if (shown >= scenes.size()) return fail(concat("there is no scene ", shown));
    Fields scene(scenes[shown]);
    TRY(scene.check());
    if (scene.has("nodes"))
      scene_nodes_ = TRY(indices_of(*scene.value("nodes"), nodes_.size(), "node"));
    return {};
  }

  static Result<std::string> name_of_extension(const JsonValue& name) {
    const auto text = name.string();
    if (!text) return fail("the name of an extension is not text");
    return *text;
  }

  /// Without scenes, the roots are shown.
  void remove_children() {
    std::vector<bool> child(nodes_.size());
    for (const JsonValue& node : nodes_) {
      Fields fields(node);
      if (!fields.has("children")) continue;
      if (const auto children = indices_of(*fields.value("children"), nodes_.size(), "node"))
        for (const std::size_t i : *children) child[i] = true;
    }
    std::erase_if(scene_nodes_, [&](std::size_t i) { return child[i]; });
  }

  static Result<std::vector<std::size_t>> indices_of(const JsonValue& array, std::size_t count,
                                                     const char* what) {
    std::vector<std::size_t> indices;
    for (JsonItems item(array); item.next();) {
      const auto index = item.value().integer();
      if (!index || *index >= count)
        return fail(
            concat("there is no ", what, " ", std::string_view(item.value().text().substr(0, 20))));
      indices.push_back(static_cast<std::size_t>(*index));
    }
    return indices;
  }

  Result<void> read_buffers() {
    decoded_.reserve(buffers_json_.size());
    for (std::size_t i = 0; i < buffers_json_.size(); ++i) {
      Fields fields(buffers_json_[i]);
      TRY(fields.check());
      if (!fields.has("uri")) {
        buffers_.push_back(i == 0 ? binary_ : ByteView());
        continue;
      }
      const std::string uri = fields.text("uri");
      TRY(fields.check());
      const std::size_t comma = uri.find(";base64,");
      if (!uri.starts_with("data:") || comma == std::string::npos) {
        return fail(ErrorCode::unsupported,
                    concat("buffers/", i,
                           " is in another file, which has not come with it: export it as "
                           ".glb, or with its data embedded"));
      }
      auto bytes = decode_base64(std::string_view(uri).substr(comma + 8));
      if (!bytes) return fail(concat("buffers/", i, " is not base64"));
      decoded_.push_back(std::move(*bytes));
      buffers_.push_back(decoded_.back());
    }
    return {};
  }

  /// The bytes of a buffer view from `offset` on. `stride` is its own, or 0.
  Result<ByteView> view_of(Fields& fields, std::size_t offset, std::size_t& stride) const {
    const std::size_t index = fields.integer("bufferView", kMaxInteger);
    TRY(fields.check());
    if (index >= views_.size()) return fail(concat("there is no bufferViews/", index));
    const std::string place = concat("bufferViews/", index);
    Fields view(views_[index]);
    const std::size_t buffer = view.integer("buffer", kMaxInteger);
    const std::size_t begin = view.has("byteOffset") ? view.integer("byteOffset", kMaxInteger) : 0;
    const std::size_t length = view.integer("byteLength", kMaxInteger);
    stride = view.has("byteStride") ? view.integer("byteStride", 252) : 0;
    if (const auto& error = view.error()) return fail_at(place, *error);
    if (buffer >= buffers_.size()) return fail(concat(place, ": there is no buffers/", buffer));
    const ByteView bytes = buffers_[buffer];
    if (begin > bytes.size() || length > bytes.size() - begin) {
      return fail(concat(place, ": ends at byte ", begin + length, " of buffers/", buffer,
                         ", which has ", bytes.size()));
    }
    return offset > length ? ByteView() : bytes.subspan(begin + offset, length - offset);
  }

  static std::optional<NumberType> component(std::uint64_t code) {
    switch (code) {
      case 5120:
        return NumberType::int8;
      case 5121:
        return NumberType::uint8;
      case 5122:
        return NumberType::int16;
      case 5123:
        return NumberType::uint16;
      case 5125:
        return NumberType::uint32;
      case 5126:
        return NumberType::float32;
      default:
        return std::nullopt;
    }
  }

  static double largest(NumberType type) {
    constexpr std::array<double, 6> kLargest{127, 255, 32767, 65535, 2147483647, 4294967295};
    return kLargest[static_cast<std::size_t>(type)];
  }

  Result<Accessor> accessor(std::size_t index) const {
    if (index >= accessors_.size()) return fail(concat("there is no accessors/", index));
    return at_place(concat("accessors/", index), parse_accessor(accessors_[index]));
  }

  Result<Accessor> parse_accessor(const JsonValue& json) const {
    Fields fields(json);
    Accessor accessor;
    const std::uint64_t code = fields.integer("componentType", kMaxInteger);
    accessor.count = fields.integer("count", kMaxInteger);
    const std::string shape = fields.text("type");
    const bool normalized = fields.has("normalized") && fields.boolean("normalized");
    const std::size_t offset =
        fields.has("byteOffset") ? fields.integer("byteOffset", kMaxInteger) : 0;
    TRY(fields.check());
    const auto type = component(code);
    if (!type) return fail(concat("there is no component type ", code));
    accessor.type = *type;
    accessor.width = shape == "SCALAR" ? 1
                     : shape == "VEC2" ? 2
                     : shape == "VEC3" ? 3
                     : shape == "VEC4" ? 4
                                       : 0;
    if (accessor.width == 0) return fail("its type is not a vector");
    if (normalized && !is_float(*type)) accessor.scale = 1.0 / largest(*type);
    const std::size_t size = accessor.width * size_of(*type);
    if (fields.has("bufferView")) {
      std::size_t stride = 0;
      accessor.bytes = TRY(view_of(fields, offset, stride));
      accessor.stride = stride == 0 ? size : stride;
      if (accessor.count > 0 &&
          (accessor.bytes.size() < size ||
           accessor.count - 1 > (accessor.bytes.size() - size) / accessor.stride)) {
        return fail(concat("its ", accessor.count, " elements do not fit into its buffer view"));
      }
    }
    if (fields.has("sparse")) TRY(parse_sparse(*fields.value("sparse"), accessor));
    if (accessor.bytes.empty() && accessor.count > 0 && accessor.others.empty())
      return fail("it has no buffer view");
    if (accessor.bytes.empty() && accessor.count > kMostZeros)
      return fail(ErrorCode::limit,
                  concat("it has ", accessor.count, " elements without a buffer"));
    return accessor;
  }

  Result<void> parse_sparse(const JsonValue& json, Accessor& accessor) const {
    Fields sparse(json);
    const std::size_t count = sparse.integer("count", kMaxInteger);
    const JsonValue* indices_json = sparse.value("indices");
    const JsonValue* values_json = sparse.value("values");
    TRY(sparse.check());
    Fields indices(*indices_json), values(*values_json);
    const auto type = component(indices.integer("componentType", kMaxInteger));
    const auto offset_of = [](Fields& of) {
      return of.has("byteOffset") ? of.integer("byteOffset", kMaxInteger) : 0;
    };
    const std::size_t index_offset = offset_of(indices), value_offset = offset_of(values);
    TRY(indices.check());
    TRY(values.check());
    if (!type || is_float(*type)) return fail("its sparse indices are not whole numbers");
    std::size_t ignored = 0;
    const ByteView index_bytes = TRY(view_of(indices, index_offset, ignored));
    const ByteView value_bytes = TRY(view_of(values, value_offset, ignored));
    const std::size_t size = accessor.width * size_of(accessor.type);
    if (count > index_bytes.size() / size_of(*type) || count > value_bytes.size() / size)
      return fail(concat("its ", count, " sparse elements do not fit into their buffer views"));
    accessor.others.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double index = numbers_at(index_bytes.data() + i * size_of(*type), *type, 1, 1.0).x;
      if (!(index >= 0.0 && index < static_cast<double>(accessor.count)))
        return fail(concat("its sparse element ", i, " is out of range"));
      accessor.others.emplace_back(
          static_cast<std::size_t>(index),
          numbers_at(value_bytes.data() + i * size, accessor.type, accessor.width, accessor.scale));
    }
    return {};
  }

  template <class Use>
  static void each(const Accessor& accessor, const Use& use) {
    for (std::size_t i = 0; i < accessor.count; ++i) {
      use(i, accessor.bytes.empty() ? glm::dvec4(0.0, 0.0, 0.0, 1.0)
                                    : numbers_at(accessor.bytes.data() + i * accessor.stride,
                                                 accessor.type, accessor.width, accessor.scale));
    }
    for (const auto& [i, value] : accessor.others) use(i, value);
  }

  static Result<glm::dmat4> matrix_of(Fields& node) {
    const auto numbers = [&](const char* key, std::size_t count) -> Result<std::vector<double>> {
      std::vector<double> all;
      for (JsonItems item(*node.value(key)); item.next() && all.size() < count;)
        all.push_back(item.value().number().value_or(std::nan("")));
      if (all.size() < count ||
          !std::all_of(all.begin(), all.end(), [](double v) { return std::isfinite(v); }))
        return fail(concat(key, " is not ", count, " numbers"));
      return all;
    };
    glm::dmat4 matrix(1.0);
    if (node.has("matrix")) {
      const auto m = TRY(numbers("matrix", 16));
      for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
      return matrix;
    }
    if (node.has("scale")) {
      const auto s = TRY(numbers("scale", 3));
      for (int i = 0; i < 3; ++i) matrix[i][i] = s[static_cast<std::size_t>(i)];
    }
    if (node.has("rotation")) {
      const auto q = TRY(numbers("rotation", 4));
      matrix = glm::mat4_cast(glm::dquat(q[3], q[0], q[1], q[2])) * matrix;
    }
    if (node.has("translation")) {
      const auto t = TRY(numbers("translation", 3));
      matrix[3] = glm::dvec4(t[0], t[1], t[2], 1.0);
    }
    return matrix;
  }

  Result<void> add_node(std::size_t index, const glm::dmat4& parent, int level) {
    const std::string place = concat("nodes/", index);
    if (shown_[index]) return fail(concat(place, " has two parents, or is below itself"));
    if (level == kMostLevels) return fail(ErrorCode::limit, concat(place, " is nested too deep"));
    shown_[index] = true;
    Fields node(nodes_[index]);
    TRY(at_place(place, node.check()));
    const glm::dmat4 matrix = parent * TRY(at_place(place, matrix_of(node)));
    if (node.has("mesh")) {
      const std::size_t mesh = node.integer("mesh", kMaxInteger);
      TRY(at_place(place, node.check()));
      TRY(add_mesh(mesh, matrix));
    }
    if (node.has("children")) {
      for (const std::size_t child :
           TRY(at_place(place, indices_of(*node.value("children"), nodes_.size(), "node"))))
        TRY(add_node(child, matrix, level + 1));
    }
    return {};
  }

  Result<void> add_mesh(std::size_t index, const glm::dmat4& matrix) {
    if (index >= meshes_.size()) return fail(concat("there is no meshes/", index));
    json_read_ += meshes_[index].text().size();
    if (json_read_ > kMostJsonRead)
      return fail(ErrorCode::limit, "the scene shows its meshes too often");
    Fields mesh(meshes_[index]);
    const JsonValue* primitives = mesh.value("primitives");
    TRY(at_place(concat("meshes/", index), mesh.check()));
    // Primitives may share their vertices, and then show different triangles of them.
    std::vector<std::size_t> shown;
    for (JsonItems item(*primitives); item.next();) {
      Fields primitive(item.value());
      const JsonValue* attributes = primitive.value("attributes");
      TRY(at_place(concat("meshes/", index), primitive.check()));
      if (primitive.has("targets")) dropped_.insert("morph targets");
      note_dropped(*attributes);
      Fields named(*attributes);
      if (!named.has("POSITION")) continue;
      const std::size_t position = named.integer("POSITION", kMaxInteger);
      TRY(at_place(concat("meshes/", index), named.check()));
      if (std::find(shown.begin(), shown.end(), position) != shown.end()) continue;
      if (shown.size() < 64) shown.push_back(position);
      TRY(at_place(concat("meshes/", index), add_primitive(primitive, named, position, matrix)));
    }
    return {};
  }

  /// Further colours, and what programs have added of their own.
  void note_dropped(const JsonValue& attributes) {
    constexpr std::size_t kMost = 64;
    for (JsonItems item(attributes); item.next() && dropped_.size() < kMost;) {
      const std::string name = item.key().string().value_or("");
      if (name.starts_with("_") || (name.starts_with("COLOR_") && name != "COLOR_0"))
        dropped_.insert(printable_name(name));
    }
  }

  /// Of a primitive's material; white without one. Textures are not looked at.
  Result<glm::dvec3> base_color(Fields& primitive) {
    glm::dvec3 base(1.0);
    if (!primitive.has("material")) return base;
    const std::size_t index = primitive.integer("material", kMaxInteger);
    TRY(primitive.check());
    if (index >= materials_.size()) return fail(concat("there is no materials/", index));
    json_read_ += materials_[index].text().size();
    if (json_read_ > kMostJsonRead)
      return fail(ErrorCode::limit, "the scene shows its materials too often");
    Fields material(materials_[index]);
    TRY(at_place(concat("materials/", index), material.check()));
    if (!material.has("pbrMetallicRoughness")) return base;
    Fields surface(*material.value("pbrMetallicRoughness"));
    TRY(at_place(concat("materials/", index), surface.check()));
    if (!surface.has("baseColorFactor")) return base;
    JsonItems item(*surface.value("baseColorFactor"));
    for (int c = 0; c < 3; ++c) {
      const auto share = item.next() ? item.value().number() : std::nullopt;
      if (!share) return fail(concat("materials/", index, ": its base colour is not 4 numbers"));
      base[c] = *share;
    }
    return base;
  }

  static glm::u16vec3 color_of(const glm::dvec3& linear) {
    glm::u16vec3 color(0);
    for (int c = 0; c < 3; ++c) {
      if (linear[c] == linear[c])
        color[c] = static_cast<std::uint16_t>(65535.0 * srgb_of(linear[c]) + 0.5);
    }
    return color;
  }

  /// Colours of the vertices of a primitive that has them, and otherwise those of its material.
  Result<void> add_colors(Fields& primitive, Fields& named, std::size_t begin) {
    const glm::dvec3 base = TRY(base_color(primitive));
    colored_ |= named.has("COLOR_0") || base != glm::dvec3(1.0);
    colors_.resize(points_.size(), color_of(base));
    if (!named.has("COLOR_0")) return {};
    const Accessor colors = TRY(accessor(named.integer("COLOR_0", kMaxInteger)));
    if (colors.count != points_.size() - begin || colors.width < 3)
      return fail("COLOR_0 does not fit POSITION");
    each(colors, [&](std::size_t i, const glm::dvec4& v) {
      colors_[begin + i] = color_of(base * glm::dvec3(v));
    });
    return {};
  }

  Result<void> add_primitive(Fields& primitive, Fields& named, std::size_t position,
                             const glm::dmat4& matrix) {
    const Accessor positions = TRY(accessor(position));
    if (positions.width != 3) return fail("POSITION has no three numbers a vertex");
    const std::size_t begin = points_.size();
    if (positions.count > most_vertices_ - begin) {
      return fail(ErrorCode::limit,
                  concat("the scene has more than ", most_vertices_, " vertices"));
    }
    points_.resize(begin + positions.count);
    each(positions, [&](std::size_t i, const glm::dvec4& v) {
      points_[begin + i] = glm::dvec3(matrix * glm::dvec4(glm::dvec3(v), 1.0));
    });
    if (named.has("NORMAL")) {
      const Accessor normals = TRY(accessor(named.integer("NORMAL", kMaxInteger)));
      if (normals.count != positions.count || normals.width != 3)
        return fail("NORMAL does not fit POSITION");
      const glm::dmat3 turn = glm::transpose(glm::inverse(glm::dmat3(matrix)));
      normals_.resize(points_.size(), glm::vec3(0.0f));
      each(normals, [&](std::size_t i, const glm::dvec4& v) {
        normals_[begin + i] = glm::vec3(turn * glm::dvec3(v));
      });
    }
    TRY(add_colors(primitive, named, begin));
    return named.check();
  }

  PointCloud finish(ReadNotes& notes) {
    RecordLayout layout;
    for (std::size_t i = 0; i < 3; ++i)
      layout.position[i] = {i * sizeof(double), sizeof(glm::dvec3), NumberType::float64};
    RecordCollector collector(layout, points_.size());
    collector.add(reinterpret_cast<const std::uint8_t*>(points_.data()), 0, points_.size());
    PointCloud cloud = collector.finish(notes);
    if (!normals_.empty()) normals_.resize(points_.size(), glm::vec3(0.0f));
    cloud.normals = std::move(normals_);
    if (colored_) cloud.colors = std::move(colors_);
    return cloud;
  }

  const JsonValue root_;
  const ByteView binary_;
  Parts nodes_, meshes_, materials_, accessors_, views_, buffers_json_;
  std::vector<std::size_t> scene_nodes_;
  std::vector<Bytes> decoded_;
  std::vector<ByteView> buffers_;
  const std::size_t most_vertices_;
  std::size_t json_read_ = 0;  ///< characters of meshes and materials
  std::vector<bool> shown_;    ///< for each node
  std::vector<glm::dvec3> points_;
  std::vector<glm::vec3> normals_;
  std::vector<glm::u16vec3> colors_;  ///< of all points, white where nothing tells them
  std::set<std::string> dropped_;     ///< names of what vertices have besides
  bool colored_ = false;              ///< something does
};

}  // namespace

Result<PointCloud> read_gltf(const ByteSource& source, const DecodeLimits& limits,
                             ReadNotes& notes) {
  Bytes room;
  const GlbChunks chunks = TRY(chunks_of(TRY(source.all(room))));
  std::string_view json(reinterpret_cast<const char*>(chunks.json.data()), chunks.json.size());
  // Chunks are filled up with spaces, and by some writers with zeros.
  while (json.ends_with('\0')) json.remove_suffix(1);
  const JsonValue root = TRY(parse_json(json));
  if (!root.is_object()) return fail("is not a glTF file: its JSON is not an object");
  return GltfReader(root, chunks.binary, limits).read(notes);
}

}  // namespace pointreel
