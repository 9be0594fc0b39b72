#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pointreel/codec.h"
#include "pointreel/draco.h"

namespace pointreel {

struct PackOptions {
  std::vector<std::filesystem::path> inputs;  ///< folders and files, see list_cloud_files
  std::filesystem::path output;
  std::string name;  ///< empty: the output folder's name without ".reel"
  EncodeOptions encode;
  /// Edge of a voxel in world units, cells centred on its multiples; it sets the octree's depth.
  std::optional<double> voxel;
  /// Learn context tables from the frames, and use them if that makes the package smaller. With
  /// Entropy::context.
  bool train = false;
  /// Bits a second, above 0, that no segment may exceed on average: what was asked for above is
  /// then the finest (RateControl).
  std::optional<double> bitrate;
  /// Milliseconds, above 0, that encoding a frame may take: depth is lowered rather than falling
  /// behind (FrameTimeControl). What is written then depends on the machine.
  std::optional<double> frame_time_ms;
  bool cube_per_frame = false;  ///< the paper's mode: each frame its own bounding cube (ERRATA 12)
  double fps = 30.0;
  std::uint32_t segment_frames = 30;
  char up = 'y';
  int threads = 0;     ///< 0: as many as there are processors
  bool force = false;  ///< replace a package that is there already
};

}  // namespace pointreel
