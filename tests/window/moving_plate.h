#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "pointreel/error.h"
#include "tests/e2e/picture.h"

namespace pointreel::window {

/// A reel in which a red plate moves from left to right, so that a picture shows which frame it is.
class MovingPlate {
 public:
  static constexpr int kFrames = 60;
  static constexpr int kFps = 5;

  /// Packs the reel into a folder. The view is from the front.
  static Result<MovingPlate> make(const std::filesystem::path& folder);

  std::string reel() const { return reel_; }
  /// The folder of input files: frame 0 and the others, one per file.
  std::filesystem::path ply(int frame) const;

  /// Returns the frame that a 16:9 picture of any size shows from the first view, or nothing if the
  /// plate is not visible. Uses the middle half of the rows, above the timeline.
  std::optional<int> frame(const e2e::Picture& picture) const;

  /// The red patch in the middle half of the picture's rows.
  static e2e::Patch plate(const e2e::Picture& picture);

 private:
  std::filesystem::path folder_;
  std::string reel_;
  double first_ = 0.0, last_ = 0.0;  ///< its place in the first and last frame, in picture heights
};

}  // namespace pointreel::window
