#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "client/playback/stage.h"

namespace pointreel {

/// Opens a stage on a thread of its own.
class Opening {
 public:
  Opening(const std::vector<Stage::Placed>& sources, const Stage::Options& options,
          const Stage::CameraFor& camera_for, const Stage::OnError& on_error)
      : stage_(std::async(std::launch::async,
                          [=] { return Stage::open(sources, options, camera_for, on_error); })) {}

  /// Nothing until it is open, or cannot be; then once.
  std::optional<Result<std::unique_ptr<Stage>>> poll() {
    if (stage_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    return stage_.get();
  }

 private:
  std::future<Result<std::unique_ptr<Stage>>> stage_;
};

}  // namespace pointreel
