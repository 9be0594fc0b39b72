#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "common/process/progress.h"
#include "server/pack/packer.h"

namespace pointreel {

/// A progress bar for packing. It is there from PackListener::begin on, until done().
class PackProgress {
 public:
  /// For as long as this object is there.
  PackListener listener(std::stop_token stop) {
    return {[this](std::uint32_t total) { bar_ = std::make_unique<Progress>("pack", total); },
            [this] { bar_->tick(); },
            [this](const std::string& line) { bar_->print("warning: " + line); }, std::move(stop)};
  }
  void done() { bar_.reset(); }

 private:
  std::unique_ptr<Progress> bar_;
};

}  // namespace pointreel
