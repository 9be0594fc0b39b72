#include "client/render/opengl/instancing/pass_programs.h"

#include <utility>

#include "common/base/try.h"

namespace pointreel {
namespace {

std::string_view vertex_file(Pass pass) {
  switch (pass) {
    case Pass::voxel_cube:
      return "instancing/shaders/voxel_cube.glsl";
    case Pass::voxel_faces:
      return "instancing/shaders/voxel_faces.glsl";
    default:
      return "instancing/shaders/surfel_vertex.glsl";
  }
}

}  // namespace

bool is_surfel(Pass pass) { return pass != Pass::voxel_cube && pass != Pass::voxel_faces; }

std::vector<std::string_view> placing_files(bool surfel) {
  return {"instancing/shaders/instance.glsl",
          surfel ? "instancing/shaders/surfel.glsl" : "instancing/shaders/voxel.glsl"};
}

std::vector<std::string_view> fragment_files(Pass pass, std::string_view footprint) {
  switch (pass) {
    case Pass::surfel_depth:
      return {footprint, "shaders/disc_depth.frag.glsl"};
    case Pass::surfel_sum:
      return {footprint, "shaders/disc_sum.frag.glsl"};
    case Pass::surfel_blend:
      return {footprint, "shaders/disc_blend.frag.glsl"};
    default:
      return {"shaders/flat.frag.glsl"};
  }
}

PassTemplate pass_template(Pass pass) {
  switch (pass) {
    case Pass::voxel_cube:
      return {GL_TRIANGLE_STRIP, 14};
    case Pass::voxel_faces:
      return {GL_TRIANGLE_FAN, 8};
    default:
      return {GL_TRIANGLE_STRIP, 4};
  }
}

PassPrograms::PassPrograms(const Stages& stages) {
  for (std::size_t i = 0; i < programs_.size(); ++i) {
    const Pass pass = static_cast<Pass>(i);
    std::vector<std::string_view> primitive = placing_files(is_surfel(pass));
    primitive.push_back(vertex_file(pass));
    std::vector<gl::Stage> all = stages(pass, std::move(primitive));
    all.push_back({GL_FRAGMENT_SHADER, fragment_files(pass, "shaders/quad_footprint.glsl")});
    programs_[i] = gl::LateProgram(std::move(all));
  }
}

Result<void> PassPrograms::use(Pass pass, const PassParameters& parameters) {
  return use_program(programs_[static_cast<std::size_t>(pass)], pass, parameters);
}

Result<void> use_program(gl::LateProgram& program, Pass pass, const PassParameters& parameters) {
  TRY(program.use());
  if (!is_surfel(pass)) return {};
  glUniform1f(0, parameters.scale);
  glUniform1f(1, parameters.tolerance);
  return {};
}

PassPrograms::Stages instanced_stages(std::string_view fetch) {
  return [fetch](Pass, std::vector<std::string_view> files) {
    files.insert(files.end(), {fetch, "instancing/shaders/instanced.vert.glsl"});
    return std::vector<gl::Stage>{{GL_VERTEX_SHADER, std::move(files)}};
  };
}

}  // namespace pointreel
