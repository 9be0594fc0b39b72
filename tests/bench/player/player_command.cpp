#include "tests/bench/player/player_command.h"

#include "tests/bench/player/player_chapters.h"
#include "tests/bench/stream/chapter.h"

namespace pointreel::bench {

void add_player_command(CLI::App& app, int& exit_code) {
  add_chapters_command(
      app, exit_code, "player",
      "the window: its start, dragging the time, its interface; prints each bar",
      {{"start", "from the start of the process to the window and to the first picture",
        run_player_start},
       {"scrub", "from a move of the mouse that drags the time to the frame that it asks for",
        run_player_scrub},
       {"interface", "what the interface takes of each picture", run_player_interface}});
}

}  // namespace pointreel::bench
