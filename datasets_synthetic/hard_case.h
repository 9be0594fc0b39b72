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

/// What reading a hard file must give. Either `error_names` is empty and the file reads as the
/// other members say, or reading fails with one line that holds every one of `error_names`: the
/// line or byte, the element, the property.
struct HardExpectation {
  std::vector<std::string> error_names;

  std::size_t points = 0;           ///< after the drop
  std::size_t dropped = 0;          ///< points without a finite position, counted in a warning
  std::size_t unknown_normals = 0;  ///< counted in a warning
  std::size_t bad_radii = 0;        ///< counted in a warning
  bool normals = false, colors = false, radii = false;
  bool packs = true;       ///< false: `pack` must refuse it in one line that names the file
  Box bounds;              ///< in world coordinates, of what is left; empty where nothing is
  double tolerance = 0.0;  ///< how far the bounds may be off, in units of the file

  std::optional<glm::u16vec3> first_color;  ///< of the first point, 0 to 65535
  std::optional<double> largest_radius;     ///< no radius may be above
  /// Of the octree that divides the bounding cube until all distinct points are apart (delta 0).
  std::optional<int> depth;
  std::optional<std::size_t> leaves;

  bool reads() const { return error_names.empty(); }
};

/// A file that programs for point clouds stumble over.
struct HardCase {
  std::string file;   ///< "NAME.ply"
  std::string stage;  ///< "ingest", "quantisation", "octree" or "drawing"
  std::string row;    ///< the kind of hardship; cases of one kind share it
  std::string title;  ///< what the file holds, in a sentence without a full stop
  std::string bytes;
  HardExpectation expect;
};

/// A ball of radius 0.5 about `center` as points of a spiral, evenly apart: x y z, and if `shaded`
/// nx ny nz and red green blue that differ on every side. The points are `type`, normals float,
/// colours uchar.
PlyTable ball(std::size_t count, const glm::dvec3& center = glm::dvec3(0.0),
              PlyType type = PlyType::float32, bool shaded = true);

/// Only x y z.
PlyTable positions(const std::vector<glm::dvec3>& points, PlyType type = PlyType::float32);

/// What the table holds by the way it was made: points that are finite, attributes by the columns'
/// names, bounds rounded to the columns' types. Says nothing of normals and radii that are unusable
/// nor of the tree.
HardExpectation expect_table(const PlyTable& table);

HardExpectation expect_error(std::vector<std::string> names);

/// The expectation with the tree that it gives.
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
