#pragma once

#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "server/pack/packer.h"
#include "tests/packed_clouds.h"

namespace pointreel {

/// Packs the frames of a folder, as often as a test wants.
class PackFolder : public testing::Test {
 protected:
  PackFolder() {
    std::filesystem::create_directory(in());
    options_ = pack_options(in(), folder_.path() / "reel");
    options_.force = true;
  }

  std::filesystem::path in() const { return folder_.path() / "in"; }

  void write(int frame, const PointCloud& cloud) {
    ASSERT_TRUE(write_ply(in() / fmt::format("{}.ply", frame), cloud));
  }

  PackSummary packed() {
    const Result<PackSummary> summary = pack(options_);
    EXPECT_TRUE(summary) << summary.error().message;
    return summary.value_or(PackSummary{});
  }

  TemporaryFolder folder_;
  PackOptions options_;
};

}  // namespace pointreel
