#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "codec/core/reel_rules.h"
#include "codec/video/views.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// What the frames of a group of a layered depth video share: FORMAT.md, "Video group".
namespace pointreel {

/// Sizes and places in pictures are multiples of this many pixels.
inline constexpr int kPatchGrain = 16;
/// The largest width and height of a picture that holds all patches.
inline constexpr int kLargestAtlas = 4096;
/// The largest value of a depth picture.
inline constexpr int kDepthValues = 1023;

/// A rectangle of one layer of a view that some frame of the group uses, and its place in the
/// pictures that are coded.
struct Patch {
  int view = 0, layer = 0;
  int x = 0, y = 0;  ///< in the view, in pixels
  int width = 0, height = 0;
  int atlas_x = 0, atlas_y = 0;  ///< in the pictures
};

/// How a view's depth becomes the values of a picture: pixels along the axis from `begin`, times
/// `steps`.
struct DepthSteps {
  float begin = 0.0f;
  float steps = 1.0f;  ///< above 0: values to a pixel's edge
};

struct VideoGroup {
  glm::dvec3 origin{0.0};  ///< the corner of the cube, in world coordinates
  double pitch = 1.0;      ///< the edge of a pixel, above 0
  int frames = 0;
  bool colors = false;
  int width = 0, height = 0;  ///< of the pictures
  std::array<DepthSteps, kViews> depth{};
  std::vector<Patch> patches;

  std::size_t pixels() const { return pixel(0, height); }
  std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

void write_video_group(const VideoGroup& group, Bytes& out);

struct ParsedVideoGroup {
  VideoGroup group;
  ByteView rest;
};
/// Trust: the bytes may be hostile. Patches lie in the pictures, which have at most kLargestAtlas^2
/// pixels, and do not overlap; numbers are finite. Errors: `invalid`, `unsupported`.
Result<ParsedVideoGroup> read_video_group(ByteView bytes);

}  // namespace pointreel
