#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/playback/layer_control.h"
#include "client/playback/play_order.h"
#include "client/playback/reel_layers.h"
#include "client/prepare/layer_choice.h"
#include "client/web/wasm/camera.h"
#include "client/web/wasm/module.h"
#include "client/web/wasm/reel.h"

using namespace pointreel;

static_assert(PR_WHOLE_FRAME == kWholeFrame);
static_assert(PR_SURFEL == static_cast<int>(DrawMode::surfel) &&
              PR_VOXEL == static_cast<int>(DrawMode::voxel) &&
              PR_POINT == static_cast<int>(DrawMode::point) &&
              PR_STRIP == static_cast<int>(DrawMode::strip));
static_assert(PR_LIMIT_NONE == static_cast<unsigned>(Limit::none) &&
              PR_LIMIT_ASKED == static_cast<unsigned>(Limit::asked) &&
              PR_LIMIT_VIEW == static_cast<unsigned>(Limit::view) &&
              PR_LIMIT_LINK == static_cast<unsigned>(Limit::link) &&
              PR_LIMIT_MACHINE == static_cast<unsigned>(Limit::machine));

struct PrControl {
  const Manifest& manifest;
  LayerControl control;
};

namespace {

PrLayers layers_of(const LayerRange& range) {
  return {range.first, range.end, range.colors ? 1u : 0u, range.normals ? 1u : 0u};
}

PrepareOptions options_of(PrMode mode, std::int32_t level, std::int32_t show_normals,
                          std::int32_t scalars, std::uint32_t most) {
  PrepareOptions options;
  if (scalars != 0) options.scalar.field = "any";
  options.mode = static_cast<DrawMode>(mode);
  options.level = level;
  options.show_normals = show_normals != 0;
  options.layers = most;
  return options;
}

PlayOrder order_of(const PrOrder& order) {
  PlayOrder play{static_cast<std::uint32_t>(order.count), order.loop != 0, order.direction, {}};
  if (order.first >= 0)
    play.range = {static_cast<std::uint32_t>(order.first), static_cast<std::uint32_t>(order.last)};
  return play;
}

std::int32_t or_none(const std::optional<std::uint32_t>& value) {
  return value ? static_cast<std::int32_t>(*value) : -1;
}

}  // namespace

std::int32_t pr_level_for(const PrReel* reel, const PrCamera* camera, std::int32_t width,
                          std::int32_t height, double pixel_size) {
  return level_for(reel->manifest, camera_of(*camera), {width, height},
                   static_cast<float>(pixel_size));
}

std::int32_t pr_level_of_layers(const PrReel* reel, std::uint32_t layers) {
  const std::vector<int> levels = levels_of(reel->manifest);
  return levels[std::clamp<std::size_t>(layers, 1, levels.size()) - 1];
}

PrControl* pr_control_new(const PrReel* reel, std::uint32_t workers, std::int32_t link) {
  return new PrControl{reel->manifest,
                       LayerControl(control_options(reel->manifest, workers, link != 0))};
}

void pr_control_free(PrControl* control) { delete control; }

void pr_control_carried(PrControl* control, double bytes, double seconds) {
  control->control.carried(static_cast<std::uint64_t>(bytes), seconds);
}

void pr_control_made(PrControl* control, std::uint32_t layers, double ms) {
  control->control.made(layers, ms);
}

void pr_control_forget_made(PrControl* control) { control->control.forget_made(); }

std::int32_t pr_control_update(PrControl* control, const PrSituation* at, PrMode mode,
                               std::int32_t show_normals, std::int32_t scalars) {
  const Manifest& manifest = control->manifest;
  const PrepareOptions options = options_of(mode, kWholeFrame, show_normals, scalars, kAllLayers);
  const LayerRange all = wanted_layers(manifest, options).layers;
  const std::uint32_t segment =
      locate(manifest, static_cast<std::uint32_t>(at->next_frame)).segment;
  const LayerCaps before = control->control.caps();
  control->control.update({at->now, at->playing != 0.0, at->frame_seconds, at->fetched,
                           at->makeable, at->made, rung_bytes(manifest, segment, all)});
  return control->control.caps() != before;
}

const PrDecision* pr_control_decide(PrControl* control, PrMode mode, std::int32_t level,
                                    std::int32_t show_normals, std::int32_t scalars,
                                    std::uint32_t most) {
  static PrDecision decision;
  const LayerDecision wanted =
      wanted_layers(control->manifest, options_of(mode, level, show_normals, scalars, most));
  const LayerDecision made = decide(control->control.caps(), wanted.layers, wanted.limit);
  decision = {layers_of(made.layers), static_cast<PrLimit>(made.limit)};
  return &decision;
}

double pr_control_rate(const PrControl* control) { return control->control.bytes_per_second(); }

std::int32_t pr_order_after(const PrOrder* order, std::uint32_t from, std::uint32_t steps) {
  return or_none(order_of(*order).after(from, steps));
}

std::int32_t pr_order_steps(const PrOrder* order, std::uint32_t from, std::uint32_t to) {
  return or_none(order_of(*order).steps(from, to));
}
