#pragma once

#include <array>
#include <functional>
#include <string_view>
#include <vector>

#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instancing/method.h"

namespace pointreel {

/// The vertices to which an instance expands.
struct PassTemplate {
  GLenum topology;
  GLsizei vertices;
};
PassTemplate pass_template(Pass pass);

bool is_surfel(Pass pass);

/// The files with the function `place`, which makes an Element of an instance: the values that its
/// vertices have in common.
std::vector<std::string_view> placing_files(bool surfel);

/// The files of the fragment stage. `footprint` is the file with the function of that name, which
/// says where on its surfel a fragment lies.
std::vector<std::string_view> fragment_files(Pass pass, std::string_view footprint);

/// Makes a program of this pass current and sets its parameters.
Result<void> use_program(gl::LateProgram& program, Pass pass, const PassParameters& parameters);

/// The programs of a method, one for each pass.
class PassPrograms {
 public:
  /// Returns the stages that make triangles. `primitive` are placing_files and the file that
  /// defines kVertices and `set_vertex`, which makes a vertex from an Element.
  using Stages =
      std::function<std::vector<gl::Stage>(Pass pass, std::vector<std::string_view> primitive)>;

  explicit PassPrograms(const Stages& stages);

  Result<void> use(Pass pass, const PassParameters& parameters);

 private:
  std::array<gl::LateProgram, kPasses> programs_;
};

/// The vertex stage of hardware instancing. `fetch` is the file that defines `fetch_instance`.
PassPrograms::Stages instanced_stages(std::string_view fetch);

}  // namespace pointreel
