#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "codec/core/triangle_mesh.h"
#include "pointreel/error.h"
#include "pointreel/up.h"

namespace pointreel {

/// Writes a binary glTF 2.0 file: one mesh, or an animation that swaps the meshes of frames, each
/// of which has a node whose scale is 1 while the frame is shown and 0 otherwise, with the
/// interpolation STEP.
///
/// glTF has y up and linear colours, so the nodes are turned where z is up, and the colours are
/// converted. Captured colours contain the light, so the material is unlit where there are colours
/// (KHR_materials_unlit; programs that do not know it light the mesh). World coordinates are those
/// of the nodes, and the meshes stay near zero.
///
/// Meshes are kept in a file beside the final one, not in memory. The errors begin with the path.
class GlbWriter {
 public:
  /// `name`: of the scene.
  GlbWriter(std::filesystem::path path, std::string name, Up up);
  ~GlbWriter();
  GlbWriter(const GlbWriter&) = delete;
  GlbWriter& operator=(const GlbWriter&) = delete;

  /// Adds the mesh of the next frame, which may be empty. Error `limit`: the file would be larger
  /// than 4 GiB, which the format does not allow.
  Result<void> add(const TriangleMesh& mesh, std::uint64_t time_us);
  /// Writes the file. `end_us`: when the last frame ends.
  Result<void> finish(std::uint64_t end_us);

 private:
  struct Frame {
    std::uint64_t time_us = 0;
    std::uint64_t offset = 0;  ///< of its bytes: positions, normals, colours, indices
    std::uint32_t vertices = 0, triangles = 0;
    bool colors = false;
    glm::vec3 min{0.0f}, max{0.0f};
    glm::dvec3 origin{0.0};
  };
  class Document;

  Result<void> append(const void* bytes, std::uint64_t size);
  Result<void> failed() const;

  std::filesystem::path path_, data_path_;
  std::string name_;
  Up up_;
  std::fstream data_;
  std::uint64_t size_ = 0;
  std::vector<Frame> frames_;
};

}  // namespace pointreel
