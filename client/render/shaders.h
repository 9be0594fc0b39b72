#pragma once

#include <string_view>

namespace pointreel {

/// The text of client/render/FILE, embedded by embed_shaders.cmake when Pointreel is built; empty
/// if there is no such file.
std::string_view shader_source(std::string_view file);

}  // namespace pointreel
