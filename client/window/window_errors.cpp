#include "client/window/window_errors.h"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "common/process/print.h"

namespace pointreel {
namespace {

constexpr std::chrono::milliseconds kBrokenFrameShown{4000}, kFailureShown{8000};

}  // namespace

void WindowErrors::failed(const std::string& message, Now now) {
  failure_ = message;
  failed_at_ = now;
  print_error("pointreel", message);
}

bool WindowErrors::look(const Stage& stage, Now now) {
  const std::string before = shown();
  // After a while nobody needs to know any more that something dropped on the window was wrong.
  if (now - failed_at_ > kFailureShown) failure_.clear();
  troubled_sources_.look(stage);
  trouble_ = troubled_sources_.now();
  if (auto broken = broken_frames_.take_newest()) {
    broken_ = *std::move(broken);
    broken_at_ = now;
  }
  if (trouble_.empty() && now - broken_at_ < kBrokenFrameShown) trouble_ = broken_;
  return shown() != before;
}

}  // namespace pointreel
