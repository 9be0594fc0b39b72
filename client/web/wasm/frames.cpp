#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/prepare/prepare.h"
#include "client/render/hole_rules.h"
#include "client/render/instances.h"
#include "client/render/view.h"
#include "client/scene/cut.h"
#include "client/scene/legend.h"
#include "client/scene/refinement.h"
#include "client/scene/scalar_colors.h"
#include "client/scene/strip_cut.h"
#include "client/scene/view_box.h"
#include "client/web/wasm/camera.h"
#include "client/web/wasm/errors.h"
#include "client/web/wasm/module.h"
#include "client/web/wasm/numbers.h"
#include "client/web/wasm/tables.h"
#include "client/web/wasm/video.h"

using namespace pointreel;

static_assert(PR_COLORS == static_cast<int>(ColorSource::colors) &&
              PR_NORMALS == static_cast<int>(ColorSource::normals) &&
              PR_PLAIN == static_cast<int>(ColorSource::plain) &&
              PR_CURVATURE == static_cast<int>(ColorSource::curvature) &&
              PR_ACCESSIBILITY == static_cast<int>(ColorSource::accessibility) &&
              PR_DEPTH == static_cast<int>(ColorSource::depth) &&
              PR_CONTOURS == static_cast<int>(ColorSource::contours));

namespace {

std::map<std::uint32_t, std::shared_ptr<const SceneFrame>> frames;

// Kept between calls: their buffers, and the spheres of the last frame that was refined.
VoxelCut cut;
StripCut strip_cut;
Refinement refinement;
std::vector<Instance> instances;
std::vector<std::uint32_t> strip_indices;

glm::dvec3 vector_of(const double* from) { return {from[0], from[1], from[2]}; }

template <class Vector>
void copy(const Vector& from, double* to) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<double>(from[i]);
}

/// What is said of the scalar field to show.
struct Shown {
  ScalarChoice choice;
  std::vector<ScalarRange> source;
};
Shown shown_scalar(std::string_view field, const PrScalar* scalar) {
  Shown shown{{std::string(field), {}}, {}};
  if (field.empty()) return shown;
  if (!std::isnan(scalar->least)) shown.choice.range = {scalar->least, scalar->most};
  const PrScalarRange& range = scalar->source;
  if (scalar->known != 0.0)
    shown.source.push_back({shown.choice.field, range.least, range.most, range.labels != 0.0});
  return shown;
}

PrepareOptions options_of(const PrPrepare& wanted) {
  PrepareOptions options;
  options.mode = static_cast<DrawMode>(static_cast<int>(wanted.mode));
  options.level = static_cast<int>(wanted.level);
  if (wanted.delta >= 0.0) options.delta = wanted.delta;
  options.show_normals = wanted.show_normals != 0.0;
  if (wanted.max_memory > 0.0) options.max_memory = static_cast<std::uint64_t>(wanted.max_memory);
  return options;
}

FrameInfo info_of(const PrPrepare& wanted) {
  return {.index = static_cast<std::uint32_t>(wanted.index),
          .time_us = static_cast<std::uint64_t>(wanted.time_us),
          .cube = {vector_of(wanted.cube_origin), wanted.cube_edge},
          .normals_estimated = wanted.normals_estimated != 0.0};
}

PrError keep(std::uint32_t key, Result<SceneFrame> frame) {
  if (!frame) return report(frame.error());
  frames.insert_or_assign(key, std::make_shared<const SceneFrame>(*std::move(frame)));
  return PR_OK;
}

PrError prepare(std::uint32_t key, const FetchedFrame& fetched, const PrPrepare& wanted,
                Shown scalar) {
  PrepareOptions options = options_of(wanted);
  options.scalar = std::move(scalar.choice);
  FrameInfo info = info_of(wanted);
  info.scalars = std::move(scalar.source);
  return keep(key, prepare_frame(fetched, info, options));
}

const std::shared_ptr<const SceneFrame>* find(std::uint32_t key) {
  const auto at = frames.find(key);
  return at == frames.end() ? nullptr : &at->second;
}

/// The camera with a wider picture around the same one, so that elements are as large as before.
struct Wide {
  Camera camera;
  glm::ivec2 size;
};
Wide widen(const PrView& view) {
  Wide wide{camera_of(view.camera), {view.width, view.height}};
  if (view.widen > 1.0) {
    const double height = std::round(view.widen * view.height);
    const double tangent = std::tan(0.5 * wide.camera.fov_y) * height / view.height;
    wide.camera.fov_y = 2.0 * std::atan(tangent);
    wide.size = {std::lround(view.widen * view.width), std::lround(height)};
  }
  return wide;
}

}  // namespace

PrError pr_prepare(std::uint32_t key, const std::uint8_t* bytes, const std::uint32_t* sizes,
                   std::uint32_t layers, const PrTables* tables, const PrPrepare* options,
                   const char* field, std::uint32_t field_size, const PrScalar* scalar) {
  FetchedFrame fetched;
  for (std::uint32_t i = 0; i < layers; ++i, sizes += 3) {
    const Chunks<std::uint32_t> chunks{sizes[0], sizes[1], sizes[2]};
    const std::uint8_t* const end = bytes + total(chunks);
    fetched.layers.push_back({Bytes(bytes, end), chunks});
    bytes = end;
  }
  if (tables != nullptr) fetched.tables = tables->tables;
  return prepare(key, fetched, *options, shown_scalar({field, field_size}, scalar));
}

PrError pr_prepare_file(std::uint32_t key, const std::uint8_t* bytes, std::uint32_t size,
                        const char* name, std::uint32_t name_size, const PrPrepare* options) {
  FetchedFrame fetched;
  fetched.file = Bytes(bytes, bytes + size);
  fetched.file_name.assign(name, name_size);
  return prepare(key, fetched, *options, {});
}

PrError pr_prepare_video(std::uint32_t key, const PrVideoFrame* frame, const std::uint16_t* depth,
                         const std::uint8_t* colors, const PrTables* tables,
                         const PrPrepare* wanted) {
  const PrepareOptions options = options_of(*wanted);
  const FrameInfo info = info_of(*wanted);
  DecodeLimits limits;
  limits.max_memory = options.max_memory;
  if (tables != nullptr) limits.tables = tables->tables.get();
  limits.spacing = spacing_for(options, info.cube);
  auto decoded = video_frame(*frame, depth, colors, limits);
  if (!decoded) return report(decoded.error());
  decoded->cube = info.cube;
  auto scene = prepare_decoded(*std::move(decoded), info, options);
  if (scene) scene->layers = 2;
  return keep(key, std::move(scene));
}

const PrFrame* pr_frame(std::uint32_t key) {
  static PrFrame answer;
  const auto* found = find(key);
  if (found == nullptr) return nullptr;
  const SceneFrame& frame = **found;
  answer.index = frame.index;
  answer.time_us = static_cast<double>(frame.time_us);
  answer.points = frame.points;
  answer.layers = frame.layers;
  answer.level = frame.level;
  answer.depth = frame.svo.depth;
  answer.is_cloud = !frame.cloud.empty();
  answer.elements =
      frame.cloud.empty() ? frame.svo.leaf_count() : static_cast<double>(frame.cloud.size());
  answer.normals_estimated = frame.normals_estimated;
  answer.memory = static_cast<double>(memory_of(frame));
  copy(frame.boxes.main.min, answer.main_box_min);
  copy(frame.boxes.main.max, answer.main_box_max);
  copy(frame.boxes.all.min, answer.box_min);
  copy(frame.boxes.all.max, answer.box_max);
  answer.boxes_rough = frame.boxes.rough;
  return &answer;
}

const char* pr_legend(std::uint32_t key) {
  static std::string lines;
  lines.clear();
  const auto* found = find(key);
  const auto legend = found != nullptr ? legend_of({{.frame = *found}}) : std::nullopt;
  if (!legend) return lines.c_str();
  lines = legend->title;
  const auto add = [](const glm::u8vec3& color, const std::string& label) {
    constexpr char kDigits[] = "0123456789abcdef";
    lines += '\n';
    for (int i = 0; i < 3; ++i) lines += {kDigits[color[i] >> 4], kDigits[color[i] & 15]};
    lines += ' ' + label;
  };
  lines += legend->labels.empty() ? "\nramp" : "\nlabels";
  for (const auto& [color, label] : legend->labels) add(color, label);
  // As many as there are between which the ramp is straight.
  constexpr int kSteps = 10;
  for (int i = 0; legend->labels.empty() && i <= kSteps; ++i)
    add(ramp_color(i / double{kSteps}), i == 0        ? legend->least
                                        : i == kSteps ? legend->most
                                                      : std::string());
  return lines.c_str();
}

const double* pr_view_box(const double* bounds, const double* boxes) {
  static double answer[6];
  const auto box_at = [](const double* at) { return Box{vector_of(at), vector_of(at + 3)}; };
  const Box box = view_box(box_at(bounds), {box_at(boxes + 6), box_at(boxes)});
  copy(box.min, answer);
  copy(box.max, answer + 3);
  return answer;
}

void pr_drop(std::uint32_t key) { frames.erase(key); }

void pr_drop_all() {
  frames.clear();
  refinement.clear();
}

const PrPacked* pr_pack(std::uint32_t key, const PrView* view) {
  static PrPacked answer;
  const auto* found = find(key);
  if (found == nullptr) {
    report({"no frame was prepared under this key", ErrorCode::not_found});
    return nullptr;
  }
  const SceneFrame& frame = **found;
  const glm::dvec3 place = vector_of(view->place);
  Wide wide = widen(*view);
  wide.camera.target -= place;
  const ElementStyle style{static_cast<DrawMode>(static_cast<int>(view->mode)),
                           static_cast<ColorSource>(static_cast<int>(view->color)),
                           view->fill_holes != 0.0, view->refine != 0.0};
  if (style.refine && style.mode == DrawMode::surfel) {
    refinement.run(*found, wide.camera, wide.size);
  } else {
    refinement.clear();
  }
  const std::vector<RefinedSurfel>& refined = refinement.surfels();
  const std::vector<bool>& divided = refinement.divided();
  const bool is_tree = style.mode == DrawMode::voxel || frame.cloud.empty();
  const glm::dvec3 origin = is_tree ? frame.svo.cube.origin : frame.cloud.origin;

  CutStats stats;
  if (is_tree)
    stats = cut.run(frame.svo, wide.camera, wide.size, static_cast<float>(view->pixel_size));
  if (style.mode == DrawMode::strip) {
    cut_strips(frame.strips,
               {.camera = wide.camera,
                .origin = origin,
                .size = wide.size,
                .pixel_size = static_cast<float>(view->pixel_size),
                .signs_unknown = frame.normals_estimated},
               strip_cut);
  } else {
    strip_cut = {};
  }
  const std::size_t points = strip_cut.points.size();
  const std::size_t most =
      refined.size() + (is_tree ? cut.nodes().size() : frame.cloud.size()) + points;
  if (instances.size() < most) instances.resize(most);
  const std::span<Instance> out(instances.data(), most);
  const std::span<Instance> rest = out.subspan(refined.size());
  InstanceBounds bounds;
  pack_refined(frame, refined, style.color, glm::vec3(0.0f), out, bounds);
  const std::size_t count =
      is_tree ? pack_nodes(frame, cut.nodes(), style, glm::vec3(wide.camera.eye() - origin),
                           glm::vec3(0.0f), divided, rest, bounds)
              : pack_points(frame, style, glm::vec3(0.0f), divided, rest, bounds);

  Instance* next = out.data() + refined.size() + count;
  for (const std::uint32_t node : strip_cut.points)
    *next++ = pack_representative(frame, frame.strips.nodes[node], style.color, glm::vec3(0.0f));
  strip_indices.clear();
  const auto append = [&frame](const std::vector<StripCut::Range>& ranges) {
    const std::size_t before = strip_indices.size();
    for (const auto& [first, size] : ranges) {
      const auto from = frame.strips.indices.begin() + static_cast<std::ptrdiff_t>(first);
      strip_indices.insert(strip_indices.end(), from, from + static_cast<std::ptrdiff_t>(size));
    }
    return static_cast<double>(strip_indices.size() - before);
  };
  answer.facing = append(strip_cut.facing);
  answer.mixed = append(strip_cut.mixed);
  answer.turned_away = view->fill_holes != 0.0 ? append(strip_cut.turned_away) : 0.0;
  answer.indices = address(strip_indices.data());
  answer.points = static_cast<double>(points);

  answer.instances = address(instances.data());
  answer.count = static_cast<double>(refined.size() + count + points);
  copy(place + origin, answer.origin);
  copy(bounds.min, answer.bounds.min);
  copy(bounds.max, answer.bounds.max);
  answer.bounds.radius = bounds.radius;
  answer.bounds.all_radii = bounds.all_radii;
  answer.bounds.count = static_cast<double>(bounds.count);
  answer.normals_estimated = frame.normals_estimated;
  answer.one_back_in = hole_rules::one_back_in(count);
  answer.light = light_strength(true, shows_own_colors(frame, style.color));
  answer.visited = stats.visited;
  answer.out_of_view = stats.out_of_view;
  answer.hidden = is_tree && style.mode == DrawMode::voxel
                      ? static_cast<double>(stats.emitted) - static_cast<double>(count)
                      : 0.0;
  return &answer;
}
