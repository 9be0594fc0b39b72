#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "client/render/renderer.h"
#include "pointreel/error.h"

namespace pointreel::bench {

/// The software renderer beside `opengl`, at 1280x720, with frames of two packages as the player
/// prepares them: the times of both, taking turns, and their errors against the true surface; the
/// share of each step, as in Table 3 of Pfister et al., Surfels; playback with both; and how much
/// pictures jump while the camera moves slowly away. Packages are made in `folder`, and removed.
Result<nlohmann::json> measure_software(Renderer& opengl, const std::filesystem::path& folder,
                                        bool quick);

}  // namespace pointreel::bench
