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

void add_stream_command(cli::Command app, int& exit_code) {
  add_chapters_command(
      app, exit_code, "stream",
      "streaming: first pictures, seeks, bad links, live, many viewers and memory",
      {{"start", "the time from opening an address to the first picture", run_start},
       {"seek", "the time from a seek, or from a move while dragging, to the picture", run_seek},
       {"rate_change", "playback while the link changes to 100, 5 and 100 Mbit/s", run_rate_change},
       {"camera_path", "bytes and picture quality while the camera comes closer", run_camera_path},
       {"faults", "the time until playback goes on after a link or a server failed", run_faults},
       {"live", "the delay from capture to picture, also beside a slow viewer", run_live},
       {"load", "frame delays of many viewers at once", run_load},
       {"throughput", "bytes over HTTP, compared with nginx", run_throughput},
       {"memory", "resident memory over many frames and connections", run_memory}});
}

}  // namespace pointreel::bench
