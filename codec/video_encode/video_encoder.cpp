#include "codec/video_encode/video_encoder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "codec/octree/frame_header.h"
#include "codec/video/av1_decoder.h"
#include "codec/video/occupancy.h"
#include "codec/video/video_frame.h"
#include "codec/video/video_group.h"
#include "codec/video_encode/av1_encoder.h"
#include "codec/video_encode/color_planes.h"
#include "codec/video_encode/decoded_points.h"
#include "codec/video_encode/depth_plane.h"
#include "codec/video_encode/fill_picture.h"
#include "codec/video_encode/leftovers.h"
#include "codec/video_encode/place_patches.h"
#include "codec/video_encode/surface_points.h"
#include "codec/video_encode/view_labels.h"
#include "codec/video_encode/view_layers.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/for_each.h"
#include "common/base/try.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// How far depths of one surface may be apart in neighbouring pixels, in pixels.
constexpr float kSameSurface = 4.0f;

bool has_colors(const PointCloud* cloud) { return cloud->has_colors(); }

/// The mean of what is known in the frames, and what continues it.
class Background {
 public:
  Background(int width, int height) : sum_(width, height), count_(sum_.values.size(), 0) {}

  void add(const Plane& plane) {
    for (std::size_t p = 0; p < plane.values.size(); ++p) {
      if (plane.known[p] == 0) continue;
      sum_.values[p] += plane.values[p];
      ++count_[p];
    }
  }
  Plane filled(const VideoGroup& group, int divisor) && {
    for (std::size_t p = 0; p < sum_.values.size(); ++p) {
      if (count_[p] == 0) continue;
      sum_.values[p] /= static_cast<float>(count_[p]);
      sum_.known[p] = 1;
    }
    fill_patches(group, divisor, nullptr, nullptr, sum_);
    return std::move(sum_);
  }

 private:
  Plane sum_;
  std::vector<std::uint16_t> count_;
};

template <class Sample>
void put_samples(const std::vector<float>& values, float most, Bytes& bytes) {
  auto* const out = reinterpret_cast<Sample*>(bytes.data());
  for (std::size_t p = 0; p < values.size(); ++p)
    out[p] = static_cast<Sample>(std::lround(std::clamp(values[p], 0.0f, most)));
}

class GroupEncoder {
 public:
  GroupEncoder(std::span<const PointCloud* const> clouds, const glm::dvec3& corner,
               const VideoOptions& options)
      : clouds_(clouds), options_(options), frames_(clouds.size()) {
    group_.origin = corner;
    group_.pitch = options.pitch;
    group_.frames = static_cast<int>(clouds.size());
    group_.colors = options.colors && std::any_of(clouds.begin(), clouds.end(), has_colors);
  }

  Result<std::vector<Chunks<Bytes>>> encode() {
    lay();
    std::vector<ViewLayers> layers;
    for (Frame& frame : frames_) layers.push_back(std::move(frame.layers));
    place_patches(layers, group_);
    if (group_.width > kLargestAtlas || group_.height > kLargestAtlas)
      return fail(ErrorCode::limit,
                  concat("the video needs pictures of ", group_.width, " x ", group_.height,
                         " pixels, more than ", kLargestAtlas,
                         " along a side: its frames lie too far apart; let fewer of them "
                         "share a segment, or remove stray points"));
    for_each_frame([&](Frame& frame, std::size_t i) {
      frame.blocks = blocks_of(group_, layers[i]);
      frame.mask = pixel_mask(group_, *frame.blocks);
      frame.depth = middle_depth(group_, layers[i], frame.points, frame.mask);
      layers[i] = {};
    });
    std::vector<std::vector<float>> depths;
    for (Frame& frame : frames_) depths.push_back(std::move(frame.depth));
    choose_depth_steps(depths, group_);
    for (std::size_t i = 0; i < frames_.size(); ++i) frames_[i].depth = std::move(depths[i]);

    const std::vector<Bytes> depth = TRY(encode_depth());
    TRY(decode_depth(depth));
    // The video encoder leaves threads idle, which meanwhile look for what the pictures lack.
    Result<std::vector<Bytes>> colors = std::vector<Bytes>(frames_.size());
    Result<std::vector<Bytes>> left = colors;
    for_each(options_.executor, 2, [&](int i) {
      if (i == 1) {
        left = encode_leftovers();
      } else if (group_.colors) {
        colors = encode_colors();
      }
    });
    if (!colors) return tl::unexpected(colors.error());
    if (!left) return tl::unexpected(left.error());
    return payloads(depth, *std::move(colors), *std::move(left));
  }

 private:
  struct Frame {
    SurfacePoints points;
    ViewLayers layers;
    std::optional<BlockMask> blocks;
    std::vector<std::uint8_t> mask;
    std::vector<float> depth;  ///< in pixels, then in steps
    DecodedDepth decoded;
  };

  template <class Body>
  void for_each_frame(const Body& body) {
    for_each(options_.executor, static_cast<int>(frames_.size()), [&](int i) {
      body(frames_[static_cast<std::size_t>(i)], static_cast<std::size_t>(i));
    });
  }

  void lay() {
    for_each_frame([&](Frame& frame, std::size_t i) {
      frame.points = surface_points(*clouds_[i], group_.origin, options_.pitch, options_.side);
    });
    ViewLabels labels;
    const ViewLayers* before = nullptr;
    for (Frame& frame : frames_) {
      frame.layers =
          lay_into_views(frame.points, labels.next(frame.points), before, options_.executor);
      before = &frame.layers;
    }
  }

  Av1Options av1(int bits, int quantizer) const {
    return {group_.width,    group_.height,   bits, group_.frames, quantizer,
            options_.preset, options_.threads};
  }

  /// The depth of a frame as values of a picture.
  Plane depth_plane(const Frame& frame) const {
    Plane plane(group_.width, group_.height);
    for (const Patch& patch : group_.patches) {
      const DepthSteps& steps = group_.depth[static_cast<std::size_t>(patch.view)];
      for (int y = patch.atlas_y; y < patch.atlas_y + patch.height; ++y) {
        for (int x = patch.atlas_x; x < patch.atlas_x + patch.width; ++x) {
          const std::size_t p = plane.at(x, y);
          if (frame.depth[p] == ViewLayer::kNone) continue;
          plane.values[p] = (frame.depth[p] - steps.begin) * steps.steps;
          plane.known[p] = 1;
        }
      }
    }
    return plane;
  }

  Result<std::vector<Bytes>> encode_depth() {
    float jump = kSameSurface;
    for (const DepthSteps& steps : group_.depth) jump = std::max(jump, kSameSurface * steps.steps);
    std::vector<Plane> planes(frames_.size(), Plane(0, 0));
    for_each_frame([&](Frame& frame, std::size_t i) {
      planes[i] = depth_plane(frame);
      frame.depth = {};
      continue_patches(group_, jump, planes[i]);
    });
    fill_all(1, planes);
    return encode_av1(av1(10, options_.depth_quantizer), [&](int i, Yuv& picture) {
      put_samples<std::uint16_t>(planes[static_cast<std::size_t>(i)].values, kDepthValues,
                                 picture.luma);
      for (Bytes* plane : {&picture.cb, &picture.cr}) {
        auto* const out = reinterpret_cast<std::uint16_t*>(plane->data());
        std::fill(out, out + plane->size() / 2, std::uint16_t{512});
      }
    });
  }

  void fill_all(int divisor, std::vector<Plane>& planes) {
    Background sum(planes.front().width, planes.front().height);
    for (const Plane& plane : planes) sum.add(plane);
    const Plane background = std::move(sum).filled(group_, divisor);
    for_each(options_.executor, static_cast<int>(planes.size()), [&](int i) {
      const auto frame = static_cast<std::size_t>(i);
      // Only what is not known of a plane changes.
      const Plane* const next = frame + 1 < planes.size() ? &planes[frame + 1] : nullptr;
      fill_patches(group_, divisor, &background, next, planes[frame]);
    });
  }

  /// Colours are those of the points that players see.
  Result<void> decode_depth(const std::vector<Bytes>& units) {
    Av1Decoder decoder = TRY(Av1Decoder::open({group_.width, group_.height, 10}, options_.threads));
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const Av1Picture picture = TRY(decoder.decode(units[i]));
      frames_[i].decoded = decoded_depth(
          group_, read_depths(group_, *frames_[i].blocks, picture.depth, options_.executor));
    }
    return {};
  }

  Result<std::vector<Bytes>> encode_colors() {
    std::vector<Plane> luma, cb, cr;
    for (Frame& frame : frames_) {
      ColorPlanes planes = color_planes(group_, frame.decoded, frame.points, options_.executor);
      luma.push_back(std::move(planes.luma));
      cb.push_back(std::move(planes.cb));
      cr.push_back(std::move(planes.cr));
    }
    fill_all(1, luma);
    fill_all(2, cb);
    fill_all(2, cr);
    return encode_av1(av1(8, options_.color_quantizer), [&](int i, Yuv& picture) {
      const auto frame = static_cast<std::size_t>(i);
      put_samples<std::uint8_t>(luma[frame].values, 255.0f, picture.luma);
      put_samples<std::uint8_t>(cb[frame].values, 255.0f, picture.cb);
      put_samples<std::uint8_t>(cr[frame].values, 255.0f, picture.cr);
    });
  }

  Result<std::vector<Chunks<Bytes>>> payloads(const std::vector<Bytes>& depth,
                                              const std::vector<Bytes>& colors,
                                              const std::vector<Bytes>& left) {
    std::vector<Chunks<Bytes>> payloads;
    OccupancyCoder occupancy(group_);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      VideoGeometry geometry;
      if (i == 0) write_video_group(group_, geometry.group);
      occupancy.encode(*frames_[i].blocks, geometry.occupancy);
      geometry.leftovers = left[i];
      geometry.depth = depth[i];
      payloads.push_back(video_chunks(static_cast<int>(i), geometry, colors[i]));
    }
    return payloads;
  }

  Result<std::vector<Bytes>> encode_leftovers() {
    std::vector<Bytes> all;
    for (std::size_t i = 0; i < frames_.size(); ++i) all.push_back(TRY(encode_leftovers(i)));
    return all;
  }

  Result<Bytes> encode_leftovers(std::size_t i) {
    const SurfacePoints& points = frames_[i].points;
    const std::vector<std::uint32_t> left =
        leftovers(group_, frames_[i].decoded, points, options_.executor);
    if (left.empty()) return Bytes{};
    const PointCloud& cloud = *clouds_[i];
    PointCloud few;
    few.origin = cloud.origin;
    for (const std::uint32_t point : left) {
      const std::uint32_t source = points.source[point];
      few.positions.push_back(cloud.positions[source]);
      if (group_.colors) few.colors.push_back(cloud.colors[source]);
    }
    // Cells of two pixels.
    const int depth = static_cast<int>(std::ceil(std::log2(options_.side))) - 1;
    OctreeOptions options;
    options.depth = DepthRule::fixed(std::min(depth, kMaxDepth));
    options.color_quality = 15;
    const Cube cube{group_.origin, 2.0 * group_.pitch * std::exp2(depth)};
    const EncodedFrame encoded = TRY(encode_octree(few, cube, options, false, group_.colors));
    Bytes bytes;
    ByteWriter writer(bytes);
    for (const Chunks<Bytes>& layer : encoded.layers) {
      for (const Bytes* chunk : {&layer.geometry, &layer.colors}) {
        writer.put(static_cast<std::uint32_t>(chunk->size()));
        bytes.insert(bytes.end(), chunk->begin(), chunk->end());
      }
    }
    return bytes;
  }

  std::span<const PointCloud* const> clouds_;
  const VideoOptions& options_;
  VideoGroup group_;
  std::vector<Frame> frames_;
};

}  // namespace

Result<std::vector<Chunks<Bytes>>> encode_video_group(std::span<const PointCloud* const> frames,
                                                      const glm::dvec3& corner,
                                                      const VideoOptions& options) {
  const auto fits = [](int value, int least, int most) { return value >= least && value <= most; };
  if (!fits(static_cast<int>(frames.size()), 1, kMostGroupFrames) ||
      !fits(options.side, 16, kLargestAtlas / 2) || !fits(options.depth_quantizer, 0, 63) ||
      !fits(options.color_quantizer, 0, 63) || !fits(options.preset, 0, 12) ||
      !(options.pitch > 0.0))
    return fail(ErrorCode::argument, "an option of the video is out of range");
  if (!is_codable({corner, options.pitch}))
    return fail(ErrorCode::limit,
                "the points lie too close together for video, or too far from the origin; multiply "
                "their coordinates");
  const bool colored = options.colors && std::any_of(frames.begin(), frames.end(), has_colors);
  for (const PointCloud* cloud : frames) {
    if (cloud->normals.size() != cloud->size())
      return fail(ErrorCode::argument, "frames of video need normals");
    if (colored && cloud->colors.size() != cloud->size())
      return fail(ErrorCode::argument, "all frames of a group of video need colours, or none");
  }
  return GroupEncoder(frames, corner, options).encode();
}

}  // namespace pointreel
