#include "tests/bench/player/player_command.h"

#include "tests/bench/player/player_chapters.h"
#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

void add_player_command(cli::Command app, int& exit_code) {
  add_chapters_command(
      app, exit_code, "player",
      "measures the window: start, dragging the timeline, interface; prints each bar",
      {{"start", "time from the start of the process to the window and to the first picture",
        run_player_start},
       {"scrub", "time from a drag of the timeline to the picture of the frame that it asks for",
        run_player_scrub},
       {"interface", "time per picture that the interface takes", run_player_interface}});
}

}  // namespace pointreel::bench
