#include "server/inspect/unpack_mesh.h"

#include "codec/files/glb_write.h"
#include "codec/files/obj_write.h"
#include "codec/files/ply.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"

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
                        MeshFormat format, const std::string& name, Up up) {
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
