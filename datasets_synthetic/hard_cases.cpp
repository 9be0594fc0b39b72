#include "datasets_synthetic/hard_cases.h"

#include <nlohmann/json.hpp>

#include "datasets_synthetic/hard_syntax.h"
#include "datasets_synthetic/hard_trees.h"
#include "datasets_synthetic/hard_values.h"

namespace pointreel {
namespace {

nlohmann::json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

nlohmann::json json_of(const HardExpectation& expect) {
  if (!expect.reads()) return {{"reads", false}, {"error_names", expect.error_names}};
  nlohmann::json json{{"reads", true},
                      {"points", expect.points},
                      {"dropped", expect.dropped},
                      {"cut_at", expect.cut_at},
                      {"unknown_normals", expect.unknown_normals},
                      {"bad_radii", expect.bad_radii},
                      {"normals", expect.normals},
                      {"colors", expect.colors},
                      {"radii", expect.radii},
                      {"packs", expect.packs}};
  if (!expect.bounds.empty()) {
    json["bounds"] = {{"min", json_of(expect.bounds.min)},
                      {"max", json_of(expect.bounds.max)},
                      {"tolerance", expect.tolerance}};
  }
  if (expect.first_color) {
    json["first_color"] = {expect.first_color->x, expect.first_color->y, expect.first_color->z};
  }
  if (expect.largest_radius) json["largest_radius"] = *expect.largest_radius;
  if (expect.depth) json["depth_at_delta_0"] = *expect.depth;
  if (expect.leaves) json["leaves_at_delta_0"] = *expect.leaves;
  return json;
}

}  // namespace

std::vector<HardCase> hard_cases() {
  std::vector<HardCase> cases;
  add_value_cases(cases);
  add_syntax_cases(cases);
  add_tree_cases(cases);
  return cases;
}

std::string hard_manifest(const std::vector<HardCase>& cases) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const HardCase& c : cases) {
    files.push_back({{"file", c.file},
                     {"stage", c.stage},
                     {"case", c.row},
                     {"holds", c.title},
                     {"bytes", c.bytes.size()},
                     {"expect", json_of(c.expect)}});
  }
  return nlohmann::ordered_json{{"files", files}}.dump(2) + "\n";
}

}  // namespace pointreel
