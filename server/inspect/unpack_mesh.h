#pragma once

#include <filesystem>
#include <string>

#include "codec/core/triangle_mesh.h"
#include "pointreel/error.h"
#include "pointreel/up.h"
#include "server/inspect/inspect.h"

namespace pointreel {

/// ".ply", ".obj" or ".glb".
const char* extension(MeshFormat format);

/// Writes one mesh. `name` and `up`: of the reel. The error begins with the path.
Result<void> write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh,
                        MeshFormat format, const std::string& name, Up up);

}  // namespace pointreel
