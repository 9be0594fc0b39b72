#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "datasets_synthetic/ply_table.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// The required outcome of reading a hard file. If `error_names` is empty, the file reads as the
/// other members say. Otherwise reading fails with a message of one line that contains every string
/// of `error_names`: the line or byte, the element, the property.
struct HardExpectation {
  std::vector<std::string> error_names;

  std::size_t points = 0;           ///< without the dropped ones
  std::size_t dropped = 0;          ///< points without a finite position, counted in a warning
  std::size_t unknown_normals = 0;  ///< counted in a warning, and estimated
  std::size_t bad_radii = 0;        ///< counted in a warning
  std::string cut_at;               ///< named in a warning that other data than points end early
  bool normals = false, colors = false, radii = false;
  bool packs = true;       ///< if not, `pack` must refuse it in one line that names the file
  Box bounds;              ///< of the remaining points, in world coordinates; empty if none remain
  double tolerance = 0.0;  ///< how far the bounds may be off, in units of the file

  std::optional<glm::u16vec3> first_color;  ///< of the first point, 0 to 65535
  std::optional<double> largest_radius;     ///< no radius may be larger
  /// Depth and number of leaves of the octree that separates all distinct points (delta 0).
  std::optional<int> depth;
  std::optional<std::size_t> leaves;

  bool reads() const { return error_names.empty(); }
};

/// A file that is hard for programs that read or show point clouds.
struct HardCase {
  std::string file;   ///< "NAME.ply"
  std::string stage;  ///< "ingest", "quantisation", "octree" or "drawing"
  std::string row;    ///< the kind of difficulty, which several cases may share
  std::string title;  ///< what the file holds, in a sentence without a full stop
  std::string bytes;
  HardExpectation expect;
};

inline constexpr std::size_t kBallPoints = 2000;  ///< enough for a look at a ball

/// A ball of radius 0.5 about `center`, made of evenly spaced points on a spiral: x y z and, if
/// `shaded`, nx ny nz and red green blue that differ on every side. Positions are of type `type`,
/// normals float, colours uchar.
PlyTable ball(std::size_t count, const glm::dvec3& center = glm::dvec3(0.0),
              PlyType type = PlyType::float32, bool shaded = true);

/// A table with the columns x y z only.
PlyTable positions(const std::vector<glm::dvec3>& points, PlyType type = PlyType::float32);

/// The expectation that follows from the table itself: finite points, attributes according to the
/// names of the columns, bounds rounded to the types of the columns. Unusable normals and radii and
/// the tree are left to the caller.
HardExpectation expect_table(const PlyTable& table);

HardExpectation expect_error(std::vector<std::string> names);

/// The expectation, extended by the depth and the number of leaves of the tree.
HardExpectation with_tree(HardExpectation expectation, int depth, std::size_t leaves);

/// Appends the cases of one stage.
class CaseList {
 public:
  CaseList(std::vector<HardCase>& cases, std::string stage)
      : cases_(cases), stage_(std::move(stage)) {}

  void add(std::string row, std::string file, std::string title, std::string bytes,
           HardExpectation expect) {
    cases_.push_back({std::move(file), stage_, std::move(row), std::move(title), std::move(bytes),
                      std::move(expect)});
  }
  void add(std::string row, std::string file, std::string title, const PlyTable& table,
           HardExpectation expect, PlyFormat format = PlyFormat::little_endian) {
    add(std::move(row), std::move(file), std::move(title), ply_text(table, format),
        std::move(expect));
  }

 private:
  std::vector<HardCase>& cases_;
  std::string stage_;
};

}  // namespace pointreel
