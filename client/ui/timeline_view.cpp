#include "client/ui/timeline_view.h"

#include <algorithm>

namespace pointreel {

TimelineView timeline_view(const Controls& controls, Controls::Now now) {
  TimelineView view;
  view.help_shown = controls.show_help;
  view.drawing_shown = controls.settings().drawing_panel;
  view.statistics_shown = controls.settings().statistics_panel;
  view.live = controls.reel() == nullptr;
  view.playing = controls.playing();
  if (view.live) return view;
  const ReelPlayback& reel = *controls.reel();
  const Timeline& timeline = reel.timeline();
  const auto begin_of = [&](std::uint32_t frame) {
    return frame < timeline.frame_count() ? timeline.times_us[frame] : timeline.duration_us;
  };
  view.timeline = &timeline;
  view.duration_us = timeline.duration_us;
  view.position_us = reel.position_us(now);
  view.frame = timeline.shown_number(view.position_us);
  view.frames = timeline.shown_count();
  const std::size_t layers = std::max<std::size_t>(1, reel.manifest().layer_names.size());
  for (const BufferedRange& part : reel.buffered())
    view.buffered.push_back(
        {begin_of(part.first), begin_of(part.last),
         layers == 1 ? 1.0f
                     : static_cast<float>(part.layers - 1) / static_cast<float>(layers - 1)});
  if (const auto range = reel.loop_range()) {
    view.loop_a_us = range->a_us;
    view.loop_b_us = range->b_us;
  } else {
    view.loop_a_us = controls.loop_begin();
  }
  view.loop = reel.loop();
  view.waiting = reel.waiting();
  view.speed = reel.speed();
  return view;
}

}  // namespace pointreel
