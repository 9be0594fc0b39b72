#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "client/render/opengl/gl_objects.h"

namespace pointreel {

/// A program that draws once into every pixel of a picture, by the main function of the last of
/// `fragment_files`.
inline gl::LateProgram picture_program(std::vector<std::string_view> fragment_files) {
  return gl::LateProgram({{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                          {GL_FRAGMENT_SHADER, std::move(fragment_files)}});
}

}  // namespace pointreel
