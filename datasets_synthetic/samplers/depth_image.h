#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/samplers/depth_cameras.h"
#include "datasets_synthetic/samplers/pinhole.h"
#include "datasets_synthetic/surface_grid.h"

namespace pointreel {

/// A pixel of a depth image. Depths are in metres along the direction of the camera.
struct DepthPixel {
  double seen = 0.0;      ///< of what the ray through its middle meets; 0: nothing
  double truth = 0.0;     ///< of the surface that was measured; for a flying pixel, of the nearest
  double measured = 0.0;  ///< with all errors; 0: nothing was measured
  bool flying = false;
  bool edge = false;  ///< a neighbouring pixel sees another surface, or only this one sees any
};

/// The part of a camera's depth image around the surface.
class DepthImage {
 public:
  /// Casts the rays and adds the errors. `distance` is the working distance; `seed` belongs to this
  /// camera and frame.
  static DepthImage take(const SurfaceGrid& grid, const Pinhole& view,
                         const DepthCameraOptions& options, double distance, std::uint64_t seed);

  /// The part that has pixels, [left, right) x [bottom, top), in pixels of the whole image.
  int left() const { return left_; }
  int right() const { return left_ + width_; }
  int bottom() const { return bottom_; }
  int top() const { return bottom_ + height_; }

  /// A pixel of this part, by its coordinates in the whole image.
  const DepthPixel& at(int x, int y) const { return pixels_[index(x, y)]; }

  /// Whether any of the pixels from (x0, y0) to (x1, y1), both included, seems to see a surface
  /// nearer than `depth` that does not continue the one there. Where the rectangle is large, not
  /// all of it is examined.
  bool anything_before(double depth, int x0, int y0, int x1, int y1) const;

  /// The depth of the nearest surface that it sees; 0 if it sees none.
  double nearest() const { return nearest_; }

  /// The direction of a pixel's ray; its component along the direction of the camera is 1.
  glm::dvec3 ray(int x, int y) const { return view_.toward(place(x), place(y)); }

  /// The normal of the plane that fits best to the depths measured around a measured pixel, as a
  /// capture tool estimates it: unit length, facing the camera.
  glm::dvec3 normal(int x, int y) const;

 private:
  class Taking;

  DepthImage(const Pinhole& view, const DepthCameraOptions& options, double distance);

  /// The coordinate in the picture plane of the middle of a pixel.
  double place(int pixel) const { return (pixel + 0.5) * pitch_ - half_field_; }

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - bottom_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x - left_);
  }

  /// The index of the lower left corner of a pixel, or of one just outside, among all corners.
  std::size_t corner(int x, int y) const {
    return static_cast<std::size_t>(y - bottom_) * static_cast<std::size_t>(width_ + 1) +
           static_cast<std::size_t>(x - left_);
  }

  /// The difference of the depths of neighbouring pixels above which they see different surfaces.
  double jump_at(double depth) const;

  /// The standard deviation of a depth on a surface that faces the camera.
  double noise_at(double depth) const { return noise_ * depth * depth; }

  Pinhole view_;
  double half_field_, pitch_, noise_;
  int left_ = 0, bottom_ = 0, width_ = 0, height_ = 0;
  double nearest_ = 0.0;
  std::vector<DepthPixel> pixels_;
  /// The number of edge pixels to the left of and below each corner of the pixels.
  std::vector<std::uint32_t> edges_;
};

}  // namespace pointreel
