#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// The chunks of one frame as they stand in a package.
struct FrameBytes {
  std::vector<Chunks<Bytes>> layers;
};

/// Reads the first `layers` layers of a frame (at least 1; more than there are count as all).
/// Bounded by the files' real sizes, whatever the manifest says.
Result<FrameBytes> read_frame(const std::filesystem::path& folder, const Manifest& manifest,
                              std::uint32_t frame, std::size_t layers);

/// The largest max_geometry_error of all frames, as their headers tell it; 0 if no frame has a
/// point. An error where a base layer cannot be read.
Result<double> max_error(const std::filesystem::path& folder, const Manifest& manifest);

struct Fault {
  std::string file;                    ///< in the package's folder
  std::optional<std::uint32_t> frame;  ///< where one frame is at fault
  std::string what;
};

struct VerifyReport {
  std::uint32_t frames = 0, files = 0;
  std::uint64_t bytes = 0;    ///< of the layer files and tables
  std::vector<Fault> faults;  ///< files first, then frames, each in order
};

/// What reading a whole package tells while it works; every member may be empty. `frame_done` is
/// called from any thread, one call at a time.
struct InspectListener {
  std::function<void(std::uint32_t total)> begin;
  std::function<void()> frame_done;
  std::stop_token stop;
};

/// Checks the size and checksum of every file and decodes every frame in full, which must give what
/// the manifest and the frame's own header promise. An error if it is no package at all.
Result<VerifyReport> verify(const std::filesystem::path& folder,
                            const InspectListener& listener = {});

struct UnpackOptions {
  std::filesystem::path input, output;
  std::size_t layers = SIZE_MAX;   ///< decode the first so many
  std::uint32_t first_frame = 0;   ///< must exist, unless the reel is empty
  std::uint32_t last_frame = ~0u;  ///< inclusive; clamped to the reel
  bool force = false;              ///< replace a folder of frame_*.ply files
};

/// Writes decoded frames as `frame_00000.ply`, ... at their original coordinates: complete or
/// absent, like pack. Returns how many.
Result<std::uint32_t> unpack(const UnpackOptions& options, const InspectListener& listener = {});

}  // namespace pointreel
