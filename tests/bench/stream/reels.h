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

/// A sequence that is streamed. It is longer than what was packed, which is shown over and over
/// under other names, so that no player has it whole.
struct StreamedReel {
  std::string name;
  std::filesystem::path folder;
  std::filesystem::path packed;  ///< once, as it was packed
  std::uint32_t packed_frames = 0, frames = 0;
  double bits_per_second = 0.0;  ///< of all layers
  /// content_of each packed frame, whole and of the base alone.
  std::vector<std::uint64_t> whole, base;
};

/// A checksum of a frame's voxels and their colours.
std::uint64_t content_of(const SceneFrame& frame);

/// soccer-shoot as the paper's scanner sees it, and kick dense on a grid of 10 bits in two slabs.
/// Made in the scratch folder by whichever chapter asks first.
Result<std::vector<StreamedReel>> streamed_reels(const StreamOptions& options);

/// A link with a name for people.
struct NamedLink {
  std::string name;
  LinkConditions conditions;
};
inline NamedLink loopback() { return {"loopback", {}}; }
/// So many Mbit/s, and 20 ms there and back.
NamedLink megabits(std::uint64_t rate);

/// streamed_reels, served by `pointreel-server serve` in a process of its own.
class ServedReels {
 public:
  static Result<std::unique_ptr<ServedReels>> start(const StreamOptions& options);

  const std::vector<StreamedReel>& reels() const { return reels_; }
  /// A link to the server.
  Result<std::unique_ptr<LinkEmulator>> link(const NamedLink& link) const;
  /// Where a reel is, directly or over a link.
  std::string url(const StreamedReel& reel) const;
  static std::string url(const LinkEmulator& link, const StreamedReel& reel);

 private:
  explicit ServedReels(std::vector<StreamedReel> reels);
  std::vector<StreamedReel> reels_;
  e2e::Background process_;
  std::string address_;
};

}  // namespace pointreel::bench
