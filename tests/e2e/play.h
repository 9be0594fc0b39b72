#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace pointreel::e2e {

/// What `pointreel play ARGUMENTS... --duration SECONDS --json -` tells, as soon as that is
/// `enough`: it plays for a second, and then for twice as long each time, since how much comes in a
/// second is the machine's affair. Gives up after a minute of playing, with what was told last;
/// discarded if that is no JSON.
nlohmann::json play_until(const std::vector<std::string>& arguments,
                          const std::function<bool(const nlohmann::json&)>& enough);

}  // namespace pointreel::e2e
