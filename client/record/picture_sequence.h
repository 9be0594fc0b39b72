#pragma once

#include <cstdint>
#include <utility>

#include "client/record/numbered_path.h"
#include "client/record/recorder.h"

namespace pointreel {

/// Writes each picture as a PNG file. The numbers of the files begin at 0; the times are ignored.
class PictureSequence : public Recorder {
 public:
  explicit PictureSequence(NumberedPath path) : path_(std::move(path)) {}

  Result<void> add(const Image& picture, std::uint64_t time_us) override;
  Result<void> finish(std::uint64_t /*end_us*/) override { return {}; }

 private:
  const NumberedPath path_;
  std::uint64_t count_ = 0;
};

}  // namespace pointreel
