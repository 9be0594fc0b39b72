#pragma once

namespace pointreel {

/// Where the colours of what is drawn come from.
enum class ColorSource {
  colors,   ///< the frame's; made from the normals where it has none
  normals,  ///< made from the normals: which way a surface faces
  plain,    ///< the same light grey everywhere: shape by light alone
};

inline constexpr int kColorSources = 3;

/// "colors", "normals", "plain".
const char* name(ColorSource source);

}  // namespace pointreel
