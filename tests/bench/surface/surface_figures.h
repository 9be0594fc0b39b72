#pragma once

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

/// What is measured of one treatment of a frame. Figures of pictures are NaN if there are none.
struct SurfaceFigures {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double points = 0.0;         ///< of the source
  double surfels = 0.0;        ///< decoded
  double removed = 0.0;        ///< points that no surface supports
  double radius_mm = 0.0;      ///< of support, the median
  double cell_mm = 0.0;        ///< that pack gives the octree; 0: chosen by the number of points
  double geometry_bits = 0.0;  ///< of each source point, as are the next three
  double color_bits = 0.0, normal_bits = 0.0, bits = 0.0;
  double surfel_bits = 0.0;                                    ///< all bits, of each decoded surfel
  double clean_ms = 0.0, encode_ms = 0.0, decode_ms = 0.0;     ///< on one thread
  double distance_rms_mm = 0.0, distance_p95_mm = 0.0;         ///< of surfels to the true surface
  double normal_mean_degrees = 0.0, normal_p95_degrees = 0.0;  ///< to the surface's normals
  /// Across the surface, between surfels of a still scene and the nearest ones of the next frame.
  double movement_rms_mm = kNone;
  double psnr = kNone, ssim = kNone, holes = kNone, iou = kNone;  ///< over the figure's pixels
};

inline constexpr auto kSurfaceFigures =
    std::to_array<std::pair<const char*, double SurfaceFigures::*>>({
        {"points", &SurfaceFigures::points},
        {"surfels", &SurfaceFigures::surfels},
        {"removed", &SurfaceFigures::removed},
        {"radius_mm", &SurfaceFigures::radius_mm},
        {"cell_mm", &SurfaceFigures::cell_mm},
        {"geometry_bits", &SurfaceFigures::geometry_bits},
        {"color_bits", &SurfaceFigures::color_bits},
        {"normal_bits", &SurfaceFigures::normal_bits},
        {"bits", &SurfaceFigures::bits},
        {"surfel_bits", &SurfaceFigures::surfel_bits},
        {"clean_ms", &SurfaceFigures::clean_ms},
        {"encode_ms", &SurfaceFigures::encode_ms},
        {"decode_ms", &SurfaceFigures::decode_ms},
        {"distance_rms_mm", &SurfaceFigures::distance_rms_mm},
        {"distance_p95_mm", &SurfaceFigures::distance_p95_mm},
        {"normal_mean_degrees", &SurfaceFigures::normal_mean_degrees},
        {"normal_p95_degrees", &SurfaceFigures::normal_p95_degrees},
        {"movement_rms_mm", &SurfaceFigures::movement_rms_mm},
        {"psnr", &SurfaceFigures::psnr},
        {"ssim", &SurfaceFigures::ssim},
        {"holes", &SurfaceFigures::holes},
        {"iou", &SurfaceFigures::iou},
    });

/// The mean of each figure, over those that were measured.
SurfaceFigures mean(const std::vector<SurfaceFigures>& all);

/// By name; NaN as null.
nlohmann::json to_json(const SurfaceFigures& figures);

}  // namespace pointreel::bench
