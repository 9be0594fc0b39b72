#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "pointreel/package.h"

/// What cleaning has done to a reel: counted, and for people and programs.
namespace pointreel {

/// Adds what was done to later frames.
void add_cleaning(Cleaning& to, const Cleaning& later);

/// One line: "3 frames: noise 0.01, spacing ...".
std::string cleaning_text(const Cleaning& cleaning);
/// null if no frame was cleaned.
nlohmann::ordered_json cleaning_json(const Cleaning& cleaning);

}  // namespace pointreel
