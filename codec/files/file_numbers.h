#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pointreel {

/// The places in a sequence that the numbers in the names of its files tell, from 0 on: frame_01,
/// frame_02 and frame_05 are at 0, 1 and 4. Empty unless exactly one number differs from name to
/// name, rises, and does so by the same step, or a multiple of it, at least as often by the step as
/// by more: times that stand in names are no such numbers. `names`: in natural order.
std::vector<std::uint64_t> places_by_number(std::span<const std::string> names);

/// The numbers that are missing between names, for people: "31 to 60, 75"; empty if there are none,
/// or places_by_number is.
std::string missing_numbers(std::span<const std::string> names);

}  // namespace pointreel
