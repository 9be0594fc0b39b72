#pragma once

#include "common/base/enum_names.h"

namespace pointreel {

/// What draws pictures.
enum class RendererChoice {
  automatic,  ///< the graphics card or, where there is none, the processor without OpenGL
  opengl,     ///< OpenGL, even if its driver is software
  software,   ///< the processor, without OpenGL
};

template <>
inline constexpr auto kEnumNames<RendererChoice> = std::to_array<EnumName<RendererChoice>>({
    {RendererChoice::automatic, "auto"},
    {RendererChoice::opengl, "opengl"},
    {RendererChoice::software, "software"},
});

}  // namespace pointreel
