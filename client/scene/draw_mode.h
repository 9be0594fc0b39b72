#pragma once

#include "common/base/enum_names.h"

namespace pointreel {

/// What is drawn for each element of a frame. It decides how frames are prepared.
enum class DrawMode { surfel, voxel, point, strip };

template <>
inline constexpr auto kEnumNames<DrawMode> = std::to_array<EnumName<DrawMode>>({
    {DrawMode::surfel, "surfel"},
    {DrawMode::voxel, "voxel"},
    {DrawMode::point, "point"},
    {DrawMode::strip, "strip"},
});

}  // namespace pointreel
