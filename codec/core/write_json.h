#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "pointreel/geometry.h"
#include "pointreel/package.h"

/// Writes the JSON of packages, live streams and camera paths.
namespace pointreel {

/// Writes the value on one line. Bytes that are not valid UTF-8, which names may contain, are
/// replaced; nothing is thrown.
std::string dump(const nlohmann::ordered_json& value);
/// The same for single values, without the library's header, which takes long to compile.
std::string dump(const std::string& value);
std::string dump(double value);

/// The member "scalars" that read_reel_head reads.
nlohmann::ordered_json scalars_json(const std::vector<ScalarRange>& scalars);
/// What parse_box reads.
nlohmann::ordered_json box_json(const Box& box);
nlohmann::ordered_json vector_json(const glm::dvec3& v);

}  // namespace pointreel
