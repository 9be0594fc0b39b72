#include "server/pack/unpack_mesh.h"

#include "common/base/try.h"
#include "common/base/write_file.h"
#include "common/cloud/ply.h"
#include "server/write/glb.h"
#include "server/write/obj.h"

namespace pointreel {

const char* extension(MeshFormat format) {
  switch (format) {
    case MeshFormat::ply:
      return ".ply";
    case MeshFormat::obj:
      return ".obj";
    case MeshFormat::glb:
      break;
  }
  return ".glb";
}

Result<void> write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh,
                        MeshFormat format, const std::string& name, char up) {
  switch (format) {
    case MeshFormat::ply:
      return write_file(path, ply_bytes(mesh.vertices, mesh.triangles));
    case MeshFormat::obj:
      return write_file(path, obj_bytes(mesh));
    case MeshFormat::glb:
      break;
  }
  GlbWriter glb(path, name, up);
  TRY(glb.add(mesh, 0));
  return glb.finish(0);
}

}  // namespace pointreel
