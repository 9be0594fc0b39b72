#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/scene/frame.h"
#include "pointreel/error.h"
#include "tests/bench/stream/chapter.h"
#include "tests/e2e/process.h"
#include "tests/link/link_emulator.h"

namespace pointreel::bench {

/// A reel to stream. It repeats the packed files under other names, so that it is too long for a
/// player to keep all of it.
struct StreamedReel {
  std::string name;
  std::filesystem::path folder;
  std::filesystem::path packed;  ///< the package without repetition
  std::uint32_t packed_frames = 0, frames = 0;
  double bits_per_second = 0.0;  ///< of all layers
  /// The content_of each packed frame with all layers, and with the base only.
  std::vector<std::uint64_t> whole, base;
};

/// A checksum of the voxels of a frame and their colours.
std::uint64_t content_of(const SceneFrame& frame);

/// "soccer-shoot" as the scanner sees it, and "kick" dense on a grid of 10 bits, in two slabs. The
/// first call makes them in the scratch folder; later calls reuse them.
Result<std::vector<StreamedReel>> streamed_reels(const StreamOptions& options);

/// A link with a name for people.
struct NamedLink {
  std::string name;
  LinkConditions conditions;
};
inline NamedLink loopback() { return {"loopback", {}}; }
/// A link of `rate` Mbit/s with a round trip of 20 ms.
NamedLink megabits(std::uint64_t rate);

/// The streamed_reels, served by `pointreel-server serve` in a process of its own.
class ServedReels {
 public:
  static Result<std::unique_ptr<ServedReels>> start(const StreamOptions& options);

  const std::vector<StreamedReel>& reels() const { return reels_; }
  /// A link to the server.
  Result<std::unique_ptr<LinkEmulator>> link(const NamedLink& link) const;
  /// The address of a reel, directly or over a link.
  std::string url(const StreamedReel& reel) const;
  static std::string url(const LinkEmulator& link, const StreamedReel& reel);

 private:
  explicit ServedReels(std::vector<StreamedReel> reels);
  std::vector<StreamedReel> reels_;
  e2e::Background process_;
  std::string address_;
};

}  // namespace pointreel::bench
