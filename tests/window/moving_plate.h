#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "pointreel/error.h"
#include "tests/e2e/picture.h"

namespace pointreel::window {

/// A reel in which a red plate goes from left to right, so that a picture tells which frame it is.
class MovingPlate {
 public:
  static constexpr int kFrames = 60;
  static constexpr int kFps = 5;

  /// Packs it into a folder; looks from the front.
  static Result<MovingPlate> make(const std::filesystem::path& folder);

  std::string reel() const { return reel_; }
  /// Frame 0 and others, one for each file.
  std::filesystem::path ply(int frame) const;

  /// Which frame a picture of 16 to 9 from the first view shows, whatever its size; nothing where
  /// the plate is not to be seen. Looks at the middle half of its rows, above the timeline.
  std::optional<int> frame(const e2e::Picture& picture) const;

  /// The red that is in the middle half of the picture's rows.
  static e2e::Patch plate(const e2e::Picture& picture);

 private:
  std::filesystem::path folder_;
  std::string reel_;
  double first_ = 0.0, last_ = 0.0;  ///< where it is in the first and the last, in heights
};

}  // namespace pointreel::window
