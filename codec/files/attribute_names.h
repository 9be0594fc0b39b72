#pragma once

#include <array>
#include <string_view>

/// The names under which files have the attributes of points. Case does not matter; if an attribute
/// has several spellings, the first complete one counts.
namespace pointreel {

using VectorNames = std::array<std::string_view, 3>;

inline constexpr std::array<VectorNames, 3> kPositionNames{
    {{"x", "y", "z"},
     {"easting", "northing", "elevation"},  // surveyors'
     {"easting", "northing", "height"}}};
inline constexpr std::array<VectorNames, 3> kNormalNames{
    {{"nx", "ny", "nz"}, {"normal_x", "normal_y", "normal_z"}, {"normalx", "normaly", "normalz"}}};
inline constexpr std::array<VectorNames, 4> kColorNames{
    {{"red", "green", "blue"},
     {"r", "g", "b"},
     {"rf", "gf", "bf"},  // CloudCompare's shares from 0 to 1
     {"diffuse_red", "diffuse_green", "diffuse_blue"}}};
/// Red, green and blue in one number of four bytes, from bits 16, 8 and 0.
inline constexpr std::array<std::string_view, 2> kPackedColorNames{"rgb", "rgba"};

/// What sensors measure of points. These become scalar fields first, where there are more numbers
/// than a cloud has scalar fields.
inline constexpr std::array<std::string_view, 12> kMeasuredNames{
    "intensity", "reflectivity", "reflectance", "amplitude", "confidence",     "range",
    "ring",      "time",         "timestamp",   "label",     "classification", "temperature"};

}  // namespace pointreel
