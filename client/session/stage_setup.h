#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

#include "client/options/play_options.h"
#include "client/playback/stage.h"
#include "client/scene/camera.h"
#include "client/scene/floor_grid.h"
#include "pointreel/error.h"

/// What the options of `pointreel play` mean for a stage and for the camera in front of it.
namespace pointreel {

Stage::Options stage_options(const PlayOptions& options);

/// Whether one picture is to be shown: of each source, which are all reels, the frame at one time.
bool is_single_frame(const PlayOptions& options);

/// When a duration that counts from the start of the program is over; without one, never.
std::chrono::steady_clock::time_point end_of_duration(const PlayOptions& options);

/// The error if no frame has come until then.
Error nothing_came(const PlayOptions& options);
/// The error if all is over, and there are sources of which no frame could be shown.
std::optional<Error> nothing_shown(const Stage& stage);

/// The time of the reel at which playback begins.
std::uint64_t start_us(const PlayOptions& options);

/// A camera for pictures of `size` pixels of a scene with these bounds: the one that the options
/// ask for, or one that frames the whole scene. A camera path is evaluated at `time_us`.
Camera camera_at(const PlayOptions& options, std::uint64_t time_us, const Box& bounds, Up up,
                 glm::ivec2 size);
/// The same at the time at which playback begins. `up` is what the package says; the settings take
/// precedence over it.
Camera first_camera(const PlayOptions& options, const Box& bounds, Up up, glm::ivec2 size);

/// Fails if no source has the scalar field that the settings name, and names those that there are.
/// Live streams may have it later.
Result<void> check_scalar_field(const Settings& settings, const Stage& stage);

/// The floor below everything that the first view shows; none while the bounds are unknown.
std::optional<FloorGrid> floor_under(const Stage& stage, const Camera& camera);

}  // namespace pointreel
