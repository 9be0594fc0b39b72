#include "codec/segments/coding_error.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/distance/distance.h"
#include "codec/surface/normals.h"
#include "codec/video/video_decoder.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace {

/// One frame in so many is compared, at most.
constexpr std::uint32_t kOneIn = 30;

Result<PointCloud> decode_video(std::span<const PackedFrame> frames, const DecodeLimits& limits) {
  VideoDecoder decoder;
  for (;;) {
    const Chunks<Bytes>& chunks = frames.front().encoded.layers.back();
    const VideoPictures pictures = TRY(decoder.next({chunks.geometry, chunks.colors, {}}, limits));
    frames = frames.subspan(1);
    if (frames.empty()) return points_of(pictures, limits);
  }
}

Result<PointCloud> decode(const PackedFrame& frame, const PackOptions& options,
                          DecodeLimits limits) {
  if (const auto* octree = std::get_if<OctreeOptions>(&options.encode.codec))
    limits.tables = octree->tables.get();
  return TRY(decode_frame(layer_views(frame.encoded.layers), limits)).cloud;
}

void add_mean(double& mean, double other, double share) { mean += (other - mean) * share; }

void add_mean(std::optional<double>& mean, const std::optional<double>& other, double share) {
  if (mean && other) {
    add_mean(*mean, *other, share);
  } else {
    mean.reset();
  }
}

std::string decibel_text(double psnr) {
  return std::isfinite(psnr) ? fmt::format("{:.1f} dB", psnr) : "without loss";
}

double luma_psnr(double mean_squared) { return color_psnr(ColorError(mean_squared)).x; }

}  // namespace

std::optional<std::size_t> compared_frame(std::uint32_t first_frame, std::size_t frames) {
  const std::uint32_t next = (first_frame + kOneIn - 1) / kOneIn * kOneIn;
  if (next - first_frame >= frames) return std::nullopt;
  return frames / 2;
}

Result<std::optional<CodingError>> coding_error(std::span<const PackedFrame> frames,
                                                const PackOptions& options) {
  DecodeLimits limits;
  limits.max_memory = ~std::uint64_t{0};  // what was just encoded can be trusted
  limits.executor = options.encode.executor;
  const PointCloud decoded =
      TRY(options.video ? decode_video(frames, limits) : decode(frames.back(), options, limits));
  const PointCloud* source = &frames.back().source->cloud;
  if (source->empty() || decoded.empty()) return std::nullopt;
  PointCloud with_normals;
  if (!source->has_normals()) {
    with_normals = *source;
    estimate_normals(with_normals, options.encode.executor);
    source = &with_normals;
  }
  const CloudDistance distance = TRY(cloud_distance(*source, decoded));
  CodingError error{1, distance.d1(), distance.d2(), std::nullopt};
  if (const auto colors = distance.colors()) error.luma = colors->x;
  return error;
}

void add_coding_error(std::optional<CodingError>& to, const CodingError& later) {
  if (!to) {
    to = later;
    return;
  }
  to->frames += later.frames;
  const double share = static_cast<double>(later.frames) / to->frames;
  add_mean(to->d1, later.d1, share);
  add_mean(to->d2, later.d2, share);
  add_mean(to->luma, later.luma, share);
}

double peak_of(const Manifest& manifest) { return manifest.segments.front().cube.edge; }

std::string coding_error_text(const CodingError& error, double peak) {
  std::string text = fmt::format("D1 {}", decibel_text(geometry_psnr(error.d1, peak)));
  if (error.d2) text += fmt::format(", D2 {}", decibel_text(geometry_psnr(*error.d2, peak)));
  if (error.luma) text += fmt::format(", luma {}", decibel_text(luma_psnr(*error.luma)));
  return fmt::format("{} ({} compared)", text, counted(error.frames, "frame"));
}

nlohmann::ordered_json coding_error_json(const std::optional<CodingError>& error, double peak) {
  if (!error) return nullptr;
  nlohmann::ordered_json json = {{"frames", error->frames}, {"peak", peak}};
  const auto add = [&json](const char* name, double psnr) {
    json[name] = nullptr;
    if (std::isfinite(psnr)) json[name] = psnr;
  };
  add("d1_psnr", geometry_psnr(error->d1, peak));
  if (error->d2) add("d2_psnr", geometry_psnr(*error->d2, peak));
  if (error->luma) add("luma_psnr", luma_psnr(*error->luma));
  return json;
}

}  // namespace pointreel
