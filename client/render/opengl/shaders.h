#pragma once

#include <string_view>

namespace pointreel {

/// The text of client/render/FILE, which embed_shaders.cmake embeds at build time. Empty if there
/// is no such file.
std::string_view shader_source(std::string_view file);

}  // namespace pointreel
