#include "client/app/player.h"

#include <cstdio>

#include <fmt/format.h>

#include "client/app/offscreen_player.h"
#include "client/window/window_player.h"
#include "common/process/print.h"
#include "common/process/stop_signal.h"

namespace pointreel {

bool play(const PlayOptions& options) {
  const StopSignal stop;
  if (!options.offscreen) return play_in_window(options, stop.token());
  const Result<void> played = play_offscreen(options, stop.token());
  if (!played) print_error("pointreel", played.error().message);
  return played.has_value();
}

}  // namespace pointreel
