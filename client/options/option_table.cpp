#include "client/options/option_table.h"

#include <algorithm>
#include <cassert>
#include <string>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "common/base/enum_names.h"

namespace pointreel {
namespace {

/// The number with the fewest digits that is the same as a float: 0.1, not 0.10000000149.
double number_of(float value) { return std::stod(fmt::format("{}", value)); }
double number_of(double value) { return value; }

// `Find` gives a member of settings, for instance [](auto& s) -> auto& { return s.floor; }.

template <class Find>
Option::Flag flag(Find) {
  return {{[](const Settings& from) { return Find{}(from); },
           [](Settings& to, bool value) { Find{}(to) = value; }}};
}

struct Slider {
  Range range;
  const char* format;
  bool logarithmic = false;
};

template <class Find>
Option::Number number(Find, Range range, Slider slider) {
  return {{[](const Settings& from) { return number_of(Find{}(from)); },
           [](Settings& to, double value) {
             auto& member = Find{}(to);
             member = static_cast<std::remove_cvref_t<decltype(member)>>(value);
           }},
          range,
          slider.range,
          slider.format,
          slider.logarithmic};
}

template <class Find>
Option::Choice choice(Find, std::vector<const char*> labels = {}) {
  using Enum = std::remove_cvref_t<decltype(Find{}(std::declval<Settings&>()))>;
  Option::Choice choice{
      {[](const Settings& from) {
         const auto& all = kEnumNames<Enum>;
         const auto found = std::find_if(all.begin(), all.end(), [&](const auto& named) {
           return named.value == Find{}(from);
         });
         return static_cast<std::size_t>(found - all.begin());
       },
       [](Settings& to, std::size_t i) { Find{}(to) = kEnumNames<Enum>[i].value; }},
      {},
      std::move(labels)};
  for (const EnumName<Enum>& named : kEnumNames<Enum>) choice.names.push_back(named.name);
  return choice;
}

std::vector<Option> make_table() {
  const Slider splat_scale{{0.25, 4.0}, "%.2f", true};
  return {
      {"window", Option::Size{{[](const Settings& from) { return from.size; },
                               [](Settings& to, glm::ivec2 size) { to.size = size; }},
                              {64, kMaxImageSide}}},
      {.name = "loop",
       .value = Option::Flag{{[](const Settings& from) { return from.loop.value_or(true); },
                              [](Settings& to, bool loop) { to.loop = loop; }}},
       .help = "Start again at the end (the default in a window), or stop there (the default "
               "offscreen)",
       .group = "Playback"},
      {.name = "volume",
       .value = number([](auto& s) -> auto& { return s.volume; }, {0, 100}, {{0, 100}, "%.0f %%"}),
       .help = "Loudness of the sound in percent: half of it sounds half as loud",
       .label = "Volume",
       .group = "Sound"},
      {.name = "mute",
       .value = flag([](auto& s) -> auto& { return s.mute; }),
       .help = "Play without sound until M is pressed",
       .label = "Mute",
       .group = "Sound"},
      {"mode",
       choice([](auto& s) -> auto& { return s.draw.mode; },
              {"Surfels", "Voxels", "Points", "Strips"}),
       "What to draw: surfels, which are discs that face along the normals; voxels, which are the "
       "cubes of the octree, down to the size of a pixel; points; or strips, which are triangles "
       "between the points",
       "Mode"},
      {"color", choice([](auto& s) -> auto& { return s.draw.color; }),
       "How to colour what is drawn: with its own colours, or grey if it has none; by the "
       "direction of its normals; in plain grey, which shows shape by light alone; by curvature, "
       "ridges in orange and valleys in blue; by accessibility, dark where other parts are near; "
       "by depth, from yellow to violet; with contours of equal height; or by a scalar field, such "
       "as intensity, whose name is given instead",
       "Colour", "Its own colours; or false ones that show its shape"},
      {"lighting", flag([](auto& s) -> auto& { return s.draw.lighting; }),
       "Light the scene from over the viewer's shoulder (the default), weakly where it has "
       "colours, which have light in them already; or show the colours as they are",
       "Lighting", "A light over your shoulder"},
      {"light", choice([](auto& s) -> auto& { return s.draw.light; }),
       "What lights the scene: flat, which is --lighting; studio, lamps that turn with the view "
       "and "
       "cast soft shadows; or environment, the light of --environment. Colours that a camera "
       "recorded already have light in them, so flat is the default",
       "Light", "Flat; lamps with soft shadows and highlights; or a picture of light"},
      {"roughness",
       number([](auto& s) -> auto& { return s.draw.roughness; }, {kLeastRoughness, 1},
              {{kLeastRoughness, 1}, "%.2f"}),
       "How rough surfaces are in the light of a studio or an environment: rougher ones have wider "
       "and weaker highlights",
       "Roughness", "Wide and weak highlights, or small and bright ones"},
      {"edl", number([](auto& s) -> auto& { return s.draw.edl; }, {0, 100}, {{0, 4}, "%.2f"}),
       "Strength of eye-dome lighting, which darkens edges in depth; 1 shows the shape of a cloud "
       "that has no normals",
       "Eye-dome", "Darkens edges in depth: shows shape without normals"},
      {"background",
       Option::Color{{[](const Settings& from) { return from.draw.background; },
                      [](Settings& to, glm::vec3 color) { to.draw.background = color; }}},
       "Colour of the background", "Background"},
      {"floor", flag([](auto& s) -> auto& { return s.floor; }),
       "Draw a grid on the floor, with steps of 1, 2 or 5 times a power of ten", "Floor grid"},
      {"point_size",
       number([](auto& s) -> auto& { return s.draw.point_size; }, {1, 64}, {{1, 16}, "%.1f px"}),
       "Width of a point in pixels; the least with --adaptive-points", "Point size"},
      {"adaptive_points", flag([](auto& s) -> auto& { return s.draw.adaptive_points; }),
       "Draw points as large as the distance between neighbours asks for (the default), so that "
       "surfaces look closed",
       "Adaptive points", "Points grow until surfaces look closed"},
      {"pixel_size",
       number([](auto& s) -> auto& { return s.draw.pixel_size; }, {0, 1000}, {{0, 16}, "%.1f px"}),
       "Parts of the octree that look smaller than this many pixels are drawn as one element; 0 "
       "draws every leaf",
       "Detail", "Parts that look smaller than this are drawn as one; 0 draws everything"},
      {.name = "voxel_merge",
       .value = number([](auto& s) -> auto& { return s.delta; }, {0, 1}, {{0, 1}, "%.2f"}),
       .help = "How far voxels are divided: the share of points that may merge with others in a "
               "voxel. 0 keeps all distinct points apart; a small share, such as the 0.05 of Slomp "
               "et al., leaves wide gaps between voxels",
       .label = "Merge",
       .tip = "Share of points that may merge in voxels: less is finer, but leaves gaps",
       .old_name = "delta"},
      {"fill_holes", flag([](auto& s) -> auto& { return s.draw.fill_holes; }),
       "Fill holes with what surrounds them (the default). With --splatting normalized this closes "
       "surfaces whose inside would show through; among voxels it closes gaps of up to three "
       "voxels",
       "Fill holes",
       "Surfels: closes holes through which the inside would show\n"
       "Voxels: closes gaps of up to three voxels"},
      {"refine", choice([](auto& s) -> auto& { return s.refine; }),
       "Divide surfels that look large, so that a close view shows a surface and not discs: auto, "
       "where a picture is not urgent; or off",
       "Refine", "Close views show a surface and not discs, where there is time"},
      {"smooth_outlines", flag([](auto& s) -> auto& { return s.smooth_outlines; }),
       "Blend outlines with the background (the default), so that they show no steps",
       "Smooth outlines", "Blends outlines with the background"},
      {"splatting", choice([](auto& s) -> auto& { return s.draw.splatting; }),
       "How surfels become a picture: normalized is a weighted mean; the other five are those of "
       "Slomp et al.",
       "Splatting",
       "How discs become a picture: a weighted mean, or the five ways of Slomp et al."},
      {"visibility_scale",
       number([](auto& s) -> auto& { return s.draw.scales.visibility; }, {0.01, 100}, splat_scale),
       "--splatting normalized enlarges surfels by this factor to decide what is visible",
       "Visible size", "Enlarges discs to decide what is hidden"},
      {"shading_scale",
       number([](auto& s) -> auto& { return s.draw.scales.shading; }, {0.01, 100}, splat_scale),
       "--splatting normalized enlarges surfels by this factor to blend their colours",
       "Colour size", "Enlarges discs to blend their colours"},
      {"renderer",
       choice([](auto& s) -> auto& { return s.renderer; }, {"Auto", "OpenGL", "Software"}),
       "What draws: opengl; software, which is the processor, without OpenGL; or auto, which takes "
       "OpenGL if there is a graphics card for it",
       "Renderer", "OpenGL, or the processor without OpenGL"},
      {"instancing", choice([](auto& s) -> auto& { return s.draw.instancing; }),
       "How OpenGL draws surfels and voxels: by a geometry shader; as instances whose "
       "data is in uniform buffers, a texture buffer or vertex attributes; or by pull, which first "
       "lists what is visible. The picture is the same",
       "Instancing", "How each element becomes triangles; the picture is the same"},
      {"drafts", choice([](auto& s) -> auto& { return s.drafts; }),
       "When the window may draw coarser pictures if time is short, with larger elements first, "
       "and then with a half or a quarter of the pixels per side: never; moving, while you move "
       "the camera or drag the timeline; or playing, also while frames play",
       "Drafts",
       "Coarser pictures if time is short: never, while you move the camera or\n"
       "drag the timeline, or also while frames play"},
      {.name = "ui_scale",
       .value = number([](auto& s) -> auto& { return s.ui_scale; }, {0, 4}, {{0, 4}, "%.2f"}),
       .help = "Size of panels and text, 0.5 to 4; 0 as the screen asks, and larger on 4K screens. "
               "The window keeps what you choose with + and -",
       .group = "Window"},
      {"drawing_panel", flag([](auto& s) -> auto& { return s.drawing_panel; })},
      {"statistics_panel", flag([](auto& s) -> auto& { return s.statistics_panel; })},
  };
}

}  // namespace

std::span<const Option> option_table() {
  static const std::vector<Option> table = make_table();
  return table;
}

const Option& find_option(std::string_view name) {
  const auto table = option_table();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const Option& option) { return option.name == name; });
  assert(found != table.end());
  return *found;
}

std::string command_line_name(std::string_view name) {
  std::string text = "--" + std::string(name);
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

void copy_value(const Option& option, const Settings& from, Settings& to) {
  std::visit([&](const auto& value) { value.set(to, value.get(from)); }, option.value);
}

}  // namespace pointreel
