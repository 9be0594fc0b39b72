#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "client/playback/stage.h"
#include "client/session/console.h"
#include "pointreel/error.h"

namespace pointreel {

/// Errors and troubles while a window plays. Each is printed on standard error, and the one that
/// matters most at the moment is shown in the window, in one line.
class WindowErrors {
 public:
  using Now = std::chrono::steady_clock::time_point;

  /// The sources that were opened last cannot be played.
  void failed(const std::string& message, Now now);
  /// Other sources are played instead.
  void forget_failure() { failure_.clear(); }
  /// A frame cannot be shown, or sound cannot be played; as ErrorLines::print. May be called by any
  /// thread.
  void broken(std::size_t source, const std::string& where, std::optional<std::uint32_t> frame,
              const Error& error) {
    broken_frames_.print(source, where, frame, error);
  }
  /// To be called a few times per second. True if shown() changed.
  bool look(const Stage& stage, Now now);

  /// Why the sources that were opened last cannot be played; empty: they can.
  const std::string& failure() const { return failure_; }
  /// The message for the window; empty: all is well.
  const std::string& shown() const { return failure_.empty() ? trouble_ : failure_; }

 private:
  ErrorLines broken_frames_;
  TroubleLines troubled_sources_;
  std::string failure_, trouble_, broken_;
  Now failed_at_{}, broken_at_{};
};

}  // namespace pointreel
