#include "codec/core/write_json.h"

#include <nlohmann/json.hpp>

namespace pointreel {

using nlohmann::ordered_json;

std::string dump(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

std::string dump(const std::string& value) { return dump(ordered_json(value)); }

std::string dump(double value) { return dump(ordered_json(value)); }

ordered_json scalars_json(const std::vector<ScalarRange>& scalars) {
  ordered_json all = ordered_json::array();
  for (const ScalarRange& range : scalars) {
    all.push_back({{"name", range.name},
                   {"min", range.least},
                   {"max", range.most},
                   {"labels", range.labels}});
  }
  return all;
}

ordered_json box_json(const Box& box) {
  if (box.empty()) return nullptr;
  return {{"min", vector_json(box.min)}, {"max", vector_json(box.max)}};
}

ordered_json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace pointreel
