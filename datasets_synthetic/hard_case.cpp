#include "datasets_synthetic/hard_case.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/trigonometry.h"

namespace pointreel {
namespace {

/// The index of the column of that name, or -1.
std::ptrdiff_t column(const PlyTable& table, const char* name) {
  const auto found = std::find_if(table.columns.begin(), table.columns.end(),
                                  [name](const auto& c) { return c.name == name; });
  return found == table.columns.end() ? -1 : found - table.columns.begin();
}

double rounded(PlyType type, double value) {
  return type == PlyType::float32 ? static_cast<double>(static_cast<float>(value)) : value;
}

}  // namespace

PlyTable ball(std::size_t count, const glm::dvec3& center, PlyType type, bool shaded) {
  PlyTable table;
  table.add_columns(type, {"x", "y", "z"});
  if (shaded) {
    table.add_columns(PlyType::float32, {"nx", "ny", "nz"});
    table.add_columns(PlyType::uint8, {"red", "green", "blue"});
  }
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {
    const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double across = std::sqrt(1.0 - y * y);
    const double angle = golden_angle * static_cast<double>(i);
    const glm::dvec3 n(across * cosine(angle), y, across * sine(angle));
    const glm::dvec3 p = center + 0.5 * n;
    std::vector<double> row{p.x, p.y, p.z};
    if (shaded) {
      row.insert(row.end(), {n.x, n.y, n.z});
      for (int axis = 0; axis < 3; ++axis) row.push_back(std::floor(127.5 + 127.0 * n[axis]));
    }
    table.rows.push_back(row);
  }
  return table;
}

PlyTable positions(const std::vector<glm::dvec3>& points, PlyType type) {
  PlyTable table;
  table.add_columns(type, {"x", "y", "z"});
  for (const glm::dvec3& p : points) table.rows.push_back({p.x, p.y, p.z});
  return table;
}

HardExpectation expect_table(const PlyTable& table) {
  HardExpectation expect;
  for (const std::vector<double>& row : table.rows) {
    glm::dvec3 p(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(column(table, axis == 0   ? "x"
                                                             : axis == 1 ? "y"
                                                                         : "z"));
      p[axis] = rounded(table.columns[at].type, row[at]);
    }
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      ++expect.dropped;
      continue;
    }
    ++expect.points;
    expect.bounds.grow(p);
  }
  const bool any = expect.points > 0;
  expect.normals = any && column(table, "nx") >= 0;
  expect.colors = any && column(table, "red") >= 0;
  expect.radii = any && column(table, "radius") >= 0;
  if (any) {
    // Half a unit in the last place of a float relative to the origin of the cloud, and of a double
    // if that origin is far away.
    const glm::dvec3 extent = expect.bounds.extent();
    const glm::dvec3 reach = glm::max(glm::abs(expect.bounds.min), glm::abs(expect.bounds.max));
    expect.tolerance = 1.2e-7 * std::max({extent.x, extent.y, extent.z}) +
                       4.5e-16 * std::max({reach.x, reach.y, reach.z});
  }
  return expect;
}

HardExpectation expect_error(std::vector<std::string> names) {
  HardExpectation expect;
  expect.error_names = std::move(names);
  return expect;
}

HardExpectation with_tree(HardExpectation expectation, int depth, std::size_t leaves) {
  expectation.depth = depth;
  expectation.leaves = leaves;
  return expectation;
}

}  // namespace pointreel
