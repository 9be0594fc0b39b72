#include "codec/files/obj.h"

#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "codec/files/ply_header.h"
#include "codec/files/records.h"
#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/parse_number.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

struct Vertex {
  glm::dvec3 position{0.0};
  glm::vec3 color{0.0f};
  float last = 0.0f;  ///< of seven numbers
  bool has_last = false;
};

class ObjReader {
 public:
  Result<PointCloud> read(std::string_view text, ReadNotes& notes) {
    Lines lines(text);
    for (std::string_view line; lines.next(line);) {
      std::string_view rest = line;
      const std::string_view keyword = take_word(rest);
      Result<void> done;
      if (keyword == "v") {
        done = add_vertex(rest);
      } else if (keyword == "vn") {
        done = add_normal(rest);
      } else if (keyword == "f") {
        // Faces are used for their normals alone: a wrong one costs no vertices.
        if (const auto added = add_corners(rest); !added && bad_faces_++ == 0)
          first_bad_face_ = concat("line ", lines.number(), ": ", added.error().message);
      }
      if (!done) return fail_at(concat("line ", lines.number()), done.error());
    }
    return finish(notes);
  }

 private:
  Result<void> add_vertex(std::string_view rest) {
    std::array<double, 7> numbers{};
    std::size_t count = 0;
    for (std::string_view word = take_word(rest); !word.empty() && word[0] != '#';
         word = take_word(rest)) {
      if (count == numbers.size()) return fail("a vertex has more than 7 numbers");
      if (!parse_number(word, numbers[count++]))
        return fail(concat("'", printable(word), "' in a vertex is not a number"));
    }
    if (count < 3) return fail(concat("a vertex has ", count, " numbers, but needs 3"));
    Vertex vertex;
    vertex.position = {numbers[0], numbers[1], numbers[2]};
    colors_ &= count >= 6;
    if (count >= 6) vertex.color = glm::vec3(numbers[3], numbers[4], numbers[5]);
    if (count == 7) {
      vertex.last = static_cast<float>(numbers[6]);
      vertex.has_last = true;
      has_weights_ &= numbers[3] == 1.0;
      has_alpha_ &= numbers[6] == 1.0;
    }
    vertices_.push_back(vertex);
    return {};
  }

  Result<void> add_normal(std::string_view rest) {
    glm::dvec3 normal(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = take_word(rest);
      if (!parse_number(word, normal[axis]))
        return fail(concat("'", printable(word), "' in a normal is not a number"));
    }
    normals_.emplace_back(normal);
    return {};
  }

  /// The number of the vertex or normal that an index stands for: from 1, or back from the newest.
  static Result<std::size_t> resolve(std::string_view word, std::size_t count, const char* what) {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    const auto all = static_cast<std::int64_t>(count);
    if (error != std::errc() || end != word.data() + word.size() || index == 0 || index > all ||
        index < -all) {
      return fail(concat("a face refers to the ", what, " '", printable(word), "', but there are ",
                         count, " so far"));
    }
    return static_cast<std::size_t>(index > 0 ? index - 1 : all + index);
  }

  /// "vertex/texture/normal" for each corner of a face.
  Result<void> add_corners(std::string_view rest) {
    for (std::string_view word = take_word(rest); !word.empty() && word[0] != '#';
         word = take_word(rest)) {
      const std::size_t first = word.find('/'), last = word.rfind('/');
      if (first == std::string_view::npos || last == first || last + 1 == word.size()) continue;
      const std::size_t vertex = TRY(resolve(word.substr(0, first), vertices_.size(), "vertex"));
      const std::size_t normal = TRY(resolve(word.substr(last + 1), normals_.size(), "normal"));
      if (sums_.size() < vertices_.size()) sums_.resize(vertices_.size(), glm::vec3(0.0f));
      sums_[vertex] += normals_[normal];
    }
    return {};
  }

  PointCloud finish(ReadNotes& notes) {
    if (bad_faces_ > 0) {
      notes.warnings.push_back(concat(first_bad_face_, "; ", bad_faces_,
                                      bad_faces_ == 1 ? " such face is" : " such faces are",
                                      " skipped, all vertices are read"));
    }
    if (has_weights_ && !has_alpha_) {
      for (Vertex& vertex : vertices_)
        if (vertex.has_last) vertex.color = {vertex.color.y, vertex.color.z, vertex.last};
    }
    RecordLayout layout;
    for (std::size_t i = 0; i < 3; ++i) {
      layout.position[i] = {offsetof(Vertex, position) + i * sizeof(double), sizeof(Vertex),
                            NumberType::float64};
    }
    if (colors_) {
      layout.color.emplace();
      for (std::size_t i = 0; i < 3; ++i) {
        (*layout.color)[i] = {offsetof(Vertex, color) + i * sizeof(float), sizeof(Vertex),
                              NumberType::float32};
      }
    }
    RecordCollector collector(layout, vertices_.size());
    collector.add(reinterpret_cast<const std::uint8_t*>(vertices_.data()), 0, vertices_.size());
    PointCloud cloud = collector.finish(notes);
    if (!sums_.empty()) {
      sums_.resize(vertices_.size(), glm::vec3(0.0f));
      cloud.normals = std::move(sums_);
    } else if (normals_.size() == vertices_.size()) {
      cloud.normals = std::move(normals_);
    }
    return cloud;
  }

  std::vector<Vertex> vertices_;
  std::vector<glm::vec3> normals_;
  std::vector<glm::vec3> sums_;  ///< of the normals of each vertex, as far as faces have any
  bool colors_ = true;           ///< all vertices have one
  /// Of seven numbers, the fourth may be a weight, which is 1, or the last an opacity.
  bool has_weights_ = true, has_alpha_ = true;
  std::size_t bad_faces_ = 0;
  std::string first_bad_face_;
};

}  // namespace

Result<PointCloud> read_obj(const ByteSource& source, ReadNotes& notes) {
  Bytes room;
  return ObjReader().read(without_utf8_mark(text_of(TRY(source.all(room)))), notes);
}

}  // namespace pointreel
