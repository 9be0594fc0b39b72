#pragma once

#include "client/options/play_options.h"
#include "client/render/opengl/gl_context.h"
#include "client/ui/window_input.h"
#include "pointreel/error.h"

namespace pointreel {

/// Keeps in options.settings_file what the user has changed of the settings, and the size of the
/// window, for the next time.
Result<void> keep_settings(const PlayOptions& options, Settings settings,
                           const WindowContext& window, const WindowInput& input);

}  // namespace pointreel
