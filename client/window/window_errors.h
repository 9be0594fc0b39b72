#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "client/playback/stage.h"
#include "client/session/console.h"
#include "pointreel/error.h"

namespace pointreel {

/// What is wrong, in one line: all of it on standard error, and in the window what is of interest
/// now.
class WindowErrors {
 public:
  using Now = std::chrono::steady_clock::time_point;

  /// What was to be played cannot be.
  void failed(const std::string& message, Now now);
  /// Something else is played instead.
  void forget_failure() { failure_.clear(); }
  /// A frame of what plays cannot be shown: ErrorLines::print. From any thread.
  void broken(std::size_t source, const std::string& where, std::uint32_t frame,
              const Error& error) {
    broken_frames_.print(source, where, frame, error);
  }
  /// To be called a few times a second. True if shown() changed.
  bool look(const Stage& stage, Now now);

  /// Of what was to be played last; empty: it plays.
  const std::string& failure() const { return failure_; }
  /// What the window shows; empty: all is well.
  const std::string& shown() const { return failure_.empty() ? trouble_ : failure_; }

 private:
  ErrorLines broken_frames_;
  TroubleLines troubled_sources_;
  std::string failure_, trouble_, broken_;
  Now failed_at_{}, broken_at_{};
};

}  // namespace pointreel
