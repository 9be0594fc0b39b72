#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/video/occupancy.h"
#include "codec/video/video_group.h"
#include "codec/video_encode/surface_points.h"
#include "codec/video_encode/view_layers.h"

namespace pointreel {

/// The blocks in which a layer has a pixel.
BlockMask blocks_of(const VideoGroup& group, const ViewLayers& layers);

/// The depth of each pixel of the group's pictures, in pixels along its view's axis, or
/// ViewLayer::kNone: that of the layers, and, where `mask` is on and they have none, that of a
/// point in the pixel's column that continues its neighbours. It is that of the middle of the
/// points of the column that are near: the surface that voxels stand for passes through them, not
/// over them.
std::vector<float> middle_depth(const VideoGroup& group, const ViewLayers& layers,
                                const SurfacePoints& points, const std::vector<std::uint8_t>& mask);

/// Sets the steps of each view, so that all frames' depth fits.
void choose_depth_steps(std::span<const std::vector<float>> frames, VideoGroup& group);

}  // namespace pointreel
