#include "tests/bench/stream/stream_command.h"

#include "tests/bench/stream/camera_path.h"
#include "tests/bench/stream/chapter.h"
#include "tests/bench/stream/faults.h"
#include "tests/bench/stream/live.h"
#include "tests/bench/stream/load.h"
#include "tests/bench/stream/memory.h"
#include "tests/bench/stream/rate_change.h"
#include "tests/bench/stream/seek.h"
#include "tests/bench/stream/start.h"
#include "tests/bench/stream/throughput.h"

namespace pointreel::bench {

void add_stream_command(CLI::App& app, int& exit_code) {
  add_chapters_command(
      app, exit_code, "stream",
      "first pictures, seeks, bad links, live, many viewers, memory; prints each bar",
      {{"start", "from an address to the first picture", run_start},
       {"seek", "from a jump, and the move of a drag, to the picture", run_seek},
       {"rate_change", "playing over 100, 5 and 100 Mbit/s", run_rate_change},
       {"camera_path", "bytes and pictures of a camera that comes nearer", run_camera_path},
       {"faults", "how soon playback goes on after links and servers failed", run_faults},
       {"live", "from capture to picture, and who is slow", run_live},
       {"load", "many viewers at once", run_load},
       {"throughput", "bytes over HTTP, against nginx", run_throughput},
       {"memory", "resident memory over frames and connections", run_memory}});
}

}  // namespace pointreel::bench
