#include "client/player.h"

#include "client/offscreen_player.h"
#include "client/window_player.h"
#include "common/base/stop_signal.h"

namespace pointreel {

Result<void> play(const PlayOptions& options) {
  const StopSignal stop;
  return options.offscreen ? play_offscreen(options, stop.token())
                           : play_in_window(options, stop.token());
}

}  // namespace pointreel
