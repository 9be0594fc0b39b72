#include "codec/files/glb_write.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/type_precision.hpp>
#include <nlohmann/json.hpp>

#include "codec/files/glb_format.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "pointreel/version.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

constexpr int kFloat = 5126, kUint16 = 5123, kUint32 = 5125;  // component types
constexpr int kVertexData = 34962, kIndexData = 34963;        // targets of buffer views
constexpr std::uint64_t kMostGlbBytes = std::numeric_limits<std::uint32_t>::max();
/// For all that is not in meshes.
constexpr std::uint64_t kSpareBytes = 1u << 26;
constexpr std::uint64_t kPositionBytes = 12, kNormalBytes = 12, kColorBytes = 8,
                        kTriangleBytes = 12;

double linear_of(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

std::uint16_t linear_of(std::uint16_t srgb) {
  return static_cast<std::uint16_t>(65535.0 * linear_of(srgb / 65535.0) + 0.5);
}

ordered_json vector_json(const auto& v) { return {v.x, v.y, v.z}; }

/// The quaternion x, y, z, w of the turn after which `up` points along y, as glTF wants it.
ordered_json rotation_to_y(Up up) {
  if (up.axis() == 1) return {up.reversed() ? 1.0 : 0.0, 0.0, 0.0, up.reversed() ? 0.0 : 1.0};
  const double half = std::sqrt(0.5), way = up.reversed() ? -half : half;
  if (up.axis() == 0) return {0.0, 0.0, way, half};
  return {-way, 0.0, 0.0, half};
}

}  // namespace

/// The JSON of a file, and the binary data that is not in meshes.
class GlbWriter::Document {
 public:
  Document(const GlbWriter& writer, std::uint64_t end_us) : writer_(writer), end_us_(end_us) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "Pointreel " POINTREEL_VERSION}};
    json_["scene"] = 0;
    json_["scenes"] = {{{"name", writer.name_}, {"nodes", {0}}}};
    root_ = {{"name", writer.name_}};
    if (writer.up_ != 'y') root_["rotation"] = rotation_to_y(writer.up_);
    while (shown_at_first_ + 1 < writer.frames_.size() && !is_shown(shown_at_first_))
      ++shown_at_first_;
    for (std::size_t i = 0; i < writer.frames_.size(); ++i) add_frame(i);
    root_["children"] = std::move(children_);
    if (root_["children"].empty()) root_.erase("children");
    nodes_.insert(nodes_.begin(), std::move(root_));
    json_["nodes"] = std::move(nodes_);
    if (!meshes_.empty()) {
      json_["meshes"] = std::move(meshes_);
      add_material();
    }
    if (writer.frames_.size() > 1) add_animation();
    const std::uint64_t size = writer.size_ + data_.size() * sizeof(float);
    if (!accessors_.empty()) {
      json_["accessors"] = std::move(accessors_);
      json_["bufferViews"] = std::move(views_);
      json_["buffers"] = {{{"byteLength", size}}};
    }
  }

  std::string text() const {
    return json_.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  }
  const std::vector<float>& data() const { return data_; }

 private:
  bool is_shown(std::size_t i) const { return end_of(i) > writer_.frames_[i].time_us; }
  std::uint64_t end_of(std::size_t i) const {
    return i + 1 < writer_.frames_.size() ? writer_.frames_[i + 1].time_us : end_us_;
  }
  double seconds(std::uint64_t time_us) const {
    return static_cast<double>(time_us - writer_.frames_[0].time_us) * 1e-6;
  }

  int add_view(std::uint64_t offset, std::uint64_t bytes, std::optional<int> target) {
    ordered_json view = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}};
    if (target) view["target"] = *target;
    views_.push_back(std::move(view));
    return static_cast<int>(views_.size()) - 1;
  }

  int add_accessor(int view, int component, std::uint64_t count, const char* type) {
    accessors_.push_back(
        {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return static_cast<int>(accessors_.size()) - 1;
  }

  void add_frame(std::size_t i) {
    const Frame& frame = writer_.frames_[i];
    const std::string name = fmt::format("frame {}", i);
    ordered_json node = {{"name", name}};
    if (frame.triangles > 0) {
      node["mesh"] = meshes_.size();
      add_mesh(frame, name);
    }
    if (frame.origin != glm::dvec3(0.0)) node["translation"] = vector_json(frame.origin);
    // Programs that play no animations show the first frame.
    if (i != shown_at_first_) node["scale"] = {0, 0, 0};
    nodes_.push_back(std::move(node));
    children_.push_back(nodes_.size());
  }

  void add_mesh(const Frame& frame, const std::string& name) {
    std::uint64_t offset = frame.offset;
    const auto view = [&](std::uint64_t bytes, int target) {
      const int number = add_view(offset, bytes, target);
      offset += bytes;
      return number;
    };
    ordered_json attributes;
    const int positions = add_accessor(view(kPositionBytes * frame.vertices, kVertexData), kFloat,
                                       frame.vertices, "VEC3");
    accessors_[positions]["min"] = vector_json(frame.min);
    accessors_[positions]["max"] = vector_json(frame.max);
    attributes["POSITION"] = positions;
    attributes["NORMAL"] = add_accessor(view(kNormalBytes * frame.vertices, kVertexData), kFloat,
                                        frame.vertices, "VEC3");
    if (frame.colors) {
      const int colors = add_accessor(view(kColorBytes * frame.vertices, kVertexData), kUint16,
                                      frame.vertices, "VEC4");
      accessors_[colors]["normalized"] = true;
      attributes["COLOR_0"] = colors;
      colors_ = true;
    }
    const int indices = add_accessor(view(kTriangleBytes * frame.triangles, kIndexData), kUint32,
                                     3ull * frame.triangles, "SCALAR");
    meshes_.push_back(
        {{"name", name},
         {"primitives", {{{"attributes", attributes}, {"indices", indices}, {"material", 0}}}}});
  }

  void add_material() {
    ordered_json material = {
        {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.9}}},
        {"doubleSided", true}};
    if (colors_) {
      material["extensions"] = {{"KHR_materials_unlit", ordered_json::object()}};
      json_["extensionsUsed"] = ordered_json::array({"KHR_materials_unlit"});
    }
    // Not in braces alone: compilers differ on whether {json} is an array or a copy.
    json_["materials"] = ordered_json::array({std::move(material)});
  }

  /// Adds floats to the data, and an accessor for them.
  int add_floats(const std::vector<float>& floats, const char* type, std::size_t width) {
    const std::uint64_t offset = writer_.size_ + data_.size() * sizeof(float);
    data_.insert(data_.end(), floats.begin(), floats.end());
    return add_accessor(add_view(offset, floats.size() * sizeof(float), std::nullopt), kFloat,
                        floats.size() / width, type);
  }

  void add_animation() {
    const auto scales = [&](std::initializer_list<float> steps) {
      std::vector<float> floats;
      for (const float step : steps) floats.insert(floats.end(), 3, step);
      return add_floats(floats, "VEC3", 3);
    };
    const int first = scales({1, 0}), middle = scales({0, 1, 0}), last = scales({0, 1, 1});
    ordered_json samplers = ordered_json::array(), channels = ordered_json::array();
    for (std::size_t i = 0; i < writer_.frames_.size(); ++i) {
      // Where several frames have the same time, the last one counts.
      const bool begins = seconds(writer_.frames_[i].time_us) > 0.0;
      if (!is_shown(i)) continue;
      std::vector<float> times;
      if (begins) times.push_back(0.0f);
      times.push_back(static_cast<float>(seconds(writer_.frames_[i].time_us)));
      times.push_back(static_cast<float>(seconds(end_of(i))));
      const int input = add_floats(times, "SCALAR", 1);
      accessors_[input]["min"] = {times.front()};
      accessors_[input]["max"] = {times.back()};
      const bool is_last = i + 1 == writer_.frames_.size();
      samplers.push_back({{"input", input},
                          {"interpolation", "STEP"},
                          {"output", !begins   ? first
                                     : is_last ? last
                                               : middle}});
      channels.push_back(
          {{"sampler", samplers.size() - 1}, {"target", {{"node", i + 1}, {"path", "scale"}}}});
    }
    if (channels.empty()) return;
    json_["animations"] = {{{"name", "frames"}, {"samplers", samplers}, {"channels", channels}}};
  }

  const GlbWriter& writer_;
  std::uint64_t end_us_;
  std::size_t shown_at_first_ = 0;
  ordered_json json_, root_;
  ordered_json nodes_ = ordered_json::array(), children_ = ordered_json::array();
  ordered_json meshes_ = ordered_json::array(), accessors_ = ordered_json::array();
  ordered_json views_ = ordered_json::array();
  std::vector<float> data_;
  bool colors_ = false;
};

GlbWriter::GlbWriter(std::filesystem::path path, std::string name, Up up)
    : path_(std::move(path)), data_path_(path_), name_(std::move(name)), up_(up) {
  data_path_ += ".data";
  data_.open(data_path_, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
}

GlbWriter::~GlbWriter() {
  data_.close();
  std::error_code ignored;
  std::filesystem::remove(data_path_, ignored);
}

Result<void> GlbWriter::failed() const {
  return fail(ErrorCode::io,
              fmt::format("{}: cannot be written: {}", path_.string(), why_not_written(errno)));
}

Result<void> GlbWriter::append(const void* bytes, std::uint64_t size) {
  if (!data_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size)))
    return failed();
  size_ += size;
  return {};
}

Result<void> GlbWriter::add(const TriangleMesh& mesh, std::uint64_t time_us) {
  const PointCloud& vertices = mesh.vertices;
  Frame frame;
  frame.time_us = time_us;
  frame.offset = size_;
  frame.vertices = static_cast<std::uint32_t>(vertices.size());
  frame.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  frame.colors = vertices.has_colors();
  frame.origin = vertices.origin;
  const std::uint64_t per_vertex = kPositionBytes + kNormalBytes + (frame.colors ? kColorBytes : 0);
  const std::uint64_t bytes = per_vertex * vertices.size() + kTriangleBytes * mesh.triangles.size();
  if (size_ + bytes + kSpareBytes > kMostGlbBytes) {
    return fail(ErrorCode::limit,
                fmt::format("{}: would be larger than 4 GiB, the most that a .glb file may be; ask "
                            "for fewer frames or triangles",
                            path_.string()));
  }
  if (frame.triangles > 0) {
    frame.min = frame.max = vertices.positions[0];
    for (const glm::vec3& p : vertices.positions) {
      frame.min = glm::min(frame.min, p);
      frame.max = glm::max(frame.max, p);
    }
    TRY(append(vertices.positions.data(), kPositionBytes * vertices.size()));
    TRY(append(vertices.normals.data(), kNormalBytes * vertices.size()));
    std::vector<glm::u16vec4> colors;
    for (const glm::u16vec3& c : vertices.colors)
      colors.emplace_back(linear_of(c.x), linear_of(c.y), linear_of(c.z), 65535);
    TRY(append(colors.data(), kColorBytes * colors.size()));
    TRY(append(mesh.triangles.data(), kTriangleBytes * mesh.triangles.size()));
  }
  frames_.push_back(frame);
  return {};
}

Result<void> GlbWriter::finish(std::uint64_t end_us) {
  const Document document(*this, end_us);
  std::string json = document.text();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::uint64_t bin = size_ + document.data().size() * sizeof(float);
  const std::uint64_t total = 12 + 8 + json.size() + (bin > 0 ? 8 + bin : 0);
  if (total > kMostGlbBytes) {
    return fail(
        ErrorCode::limit,
        fmt::format("{}: would be larger than 4 GiB; ask for fewer frames", path_.string()));
  }
  std::ofstream out(path_, std::ios::binary);
  const auto put = [&out](std::uint64_t word) {
    const auto value = static_cast<std::uint32_t>(word);
    out.write(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  put(kGlbMagic);
  put(2);
  put(total);
  put(json.size());
  put(kGlbJson);
  out.write(json.data(), static_cast<std::streamsize>(json.size()));
  if (bin > 0) {
    put(bin);
    put(kGlbBinary);
    data_.flush();
    data_.seekg(0);
    if (size_ > 0) out << data_.rdbuf();
    out.write(reinterpret_cast<const char*>(document.data().data()),
              static_cast<std::streamsize>(document.data().size() * sizeof(float)));
  }
  out.close();
  if (!out || !data_) return failed();
  return {};
}

}  // namespace pointreel
