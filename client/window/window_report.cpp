#include "client/window/window_report.h"

namespace pointreel {

void describe_end(const Controls& controls, Controls::Now now, WindowReport& report) {
  report.camera = controls.camera();
  report.playing = controls.playing();
  report.help = controls.show_help;
  report.drawing = controls.settings().drawing_panel;
  report.statistics = controls.settings().statistics_panel;
  report.floor = controls.settings().floor;
  report.flying = controls.flying();
  const ReelPlayback* reel = controls.reel();
  if (!reel) return;
  report.loop = reel->loop();
  report.speed = reel->speed();
  report.loop_range = reel->loop_range();
  const std::uint64_t position_us = reel->position_us(now);
  report.position_s = static_cast<double>(position_us) * 1e-6;
  report.frame = reel->timeline().frame_at(position_us);
}

}  // namespace pointreel
