#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "codec/files/write_cloud.h"
#include "codec/mesh/make_mesh.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/store/package_files.h"

/// What `info`, `verify` and `unpack` do with a package.
namespace pointreel {

/// Reads the first `layers` layers of a frame, base first: at least 1, and no more than there are.
/// Memory is bounded by the sizes of the files, whatever the manifest says.
Result<std::vector<Chunks<Bytes>>> read_frame(const PackageFiles& files, const Manifest& manifest,
                                              std::uint32_t frame, std::size_t layers);

/// How far a point can be from its decoded position: what the packer measured, or else the largest
/// max_geometry_error of all frames, by their headers. 0 if no frame has a point.
Result<double> max_error(const PackageFiles& files, const Manifest& manifest);

struct Fault {
  std::string file;                    ///< in the package's folder
  std::optional<std::uint32_t> frame;  ///< absent if the whole file is at fault
  std::string what;
};

struct VerifyReport {
  std::uint32_t frames = 0, files = 0;
  std::uint64_t bytes = 0;    ///< of all files but the manifest
  std::vector<Fault> faults;  ///< of files first, then of frames, each in order
};

/// How reading a whole package reports its progress; every member may be empty. `frame_done` is
/// called from any thread, one call at a time.
struct InspectListener {
  std::function<void(std::uint32_t total)> begin;
  std::function<void()> frame_done;
  std::stop_token stop;
};

/// Checks the size and checksum of every file, decodes the sound and every frame in full, and
/// compares it with what the manifest and the frame's own header say. An error if it is no
/// package.
///
/// `max_memory`: as in DecodeLimits.
Result<VerifyReport> verify(const PackageFiles& files, const InspectListener& listener = {},
                            std::uint64_t max_memory = kFrameMemory);

/// UnpackOptions::last_frame: the last frame that there is.
inline constexpr std::uint32_t kToTheEnd = ~0u;

/// The files that meshes are written to.
enum class MeshFormat : std::uint8_t { ply, obj, glb };

struct UnpackMesh {
  MeshFormat format = MeshFormat::ply;
  MeshOptions options;
  /// All frames in one file, `animation.glb`, which plays at the times of the reel. Needs
  /// MeshFormat::glb.
  bool animation = false;
};

struct UnpackOptions {
  PackageFiles input;
  std::filesystem::path output;
  std::size_t layers = SIZE_MAX;  ///< how many layers to decode, from the base
  /// Which frames, of those that are shown. Both must exist, unless the reel is empty.
  std::uint32_t first_frame = 0, last_frame = kToTheEnd;
  bool force = false;                       ///< replace a folder of such files
  PointsFormat format = PointsFormat::ply;  ///< of files of points
  bool recording = false;                   ///< write one recording instead, `recording.mcap`
  std::optional<UnpackMesh> mesh = {};      ///< write meshes instead of points
  bool voxels = false;                      ///< of video: write surface_voxels instead of points
  std::uint64_t max_memory = kFrameMemory;  ///< DecodeLimits::max_memory
};

struct UnpackReport {
  std::uint32_t frames = 0;
  std::uint64_t triangles = 0;     ///< of all meshes
  std::uint32_t without_mesh = 0;  ///< frames with points through which no surface goes
  std::vector<LostValues> lost;    ///< in files LAS, of all frames, each field once, by its name
};

/// Writes decoded frames as `frame_00000.ply`, ..., and the whole sound as `audio.opus`, at their
/// original coordinates; names end as the format says. Or all frames are in one file, an animation
/// of meshes or a recording, in which frames have their times in the reel. Like a package, the
/// folder is either complete or absent.
Result<UnpackReport> unpack(const UnpackOptions& options, const InspectListener& listener = {});

}  // namespace pointreel
