// What the server's commands leave behind, and say, when the disk is full.

#include "tests/full_disk.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/process/ffmpeg.h"
#include "server/edit/cut_package.h"
#include "server/edit/join_packages.h"
#include "server/inspect/inspect.h"
#include "server/pack/audio.h"
#include "tests/packed_clouds.h"
#include "tests/tone.h"

namespace pointreel::full_disk_test {
namespace {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class FullDiskTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!is_installed("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
    write_frames(folder_ / "in", 5);
    write_wav(sound(), 44'100, 8'820, [](std::uint32_t n) { return n % 100 < 50 ? 0.5 : -0.5; });
    PackOptions options = pack_options(folder_ / "in", reel());
    options.audio = sound();
    ASSERT_TRUE(pack(options));
    fs::create_directory(out());
  }

  fs::path sound() const { return folder_ / "tone.wav"; }
  fs::path reel() const { return folder_ / "reel"; }
  /// The only folder that the work may change.
  fs::path out() const { return folder_ / "out"; }

  /// The same package, whose files must be copied: links to symbolic links are not made.
  fs::path linked_reel() const {
    const fs::path linked = folder_ / "linked";
    fs::create_directory(linked);
    for (const std::string& name : names_in(reel()))
      fs::create_symlink(reel() / name, linked / name);
    return linked;
  }

  /// Does the work with room for more and more bytes in each file, until it succeeds. Before that,
  /// it names a file that could not be written, and leaves nothing.
  void expect_whole_or_nothing(const std::function<Result<void>(const fs::path& to)>& work) const {
    for (rlim_t room = 0;; room = std::max<rlim_t>(64, 2 * room)) {
      Result<void> done;
      {
        const FullDisk disk(room);
        done = work(out() / "made");
      }
      if (done) {
        EXPECT_GT(room, 0u) << "nothing was written";
        return;
      }
      EXPECT_THAT(done.error().message,
                  AnyOf(StartsWith((out() / ".made.partial-").string()),
                        HasSubstr(" cannot be copied to " + (out() / ".made.partial-").string())))
          << "with " << room << " bytes";
      ASSERT_THAT(names_in(out()), IsEmpty()) << "with " << room << " bytes";
    }
  }

  const TemporaryFolder folder_;
};

TEST_F(FullDiskTest, pack_names_the_file_and_leaves_nothing) {
  expect_whole_or_nothing([this](const fs::path& to) -> Result<void> {
    PackOptions options = pack_options(folder_ / "in", to);
    options.audio = sound();
    TRY(pack(options));
    return {};
  });
}

TEST_F(FullDiskTest, cut_and_join_name_the_file_and_leave_nothing) {
  for (const fs::path& input : {reel(), linked_reel()}) {
    expect_whole_or_nothing([&](const fs::path& to) -> Result<void> {
      TRY(cut_package({.input = input, .output = to}, {}));
      fs::remove_all(to);
      return {};
    });
    expect_whole_or_nothing([&](const fs::path& to) -> Result<void> {
      TRY(join_packages({.inputs = {input, input}, .output = to}, {}));
      fs::remove_all(to);
      return {};
    });
  }
}

TEST_F(FullDiskTest, unpack_names_the_file_and_leaves_nothing) {
  const auto unpack_as = [this](const UnpackOptions& how) {
    expect_whole_or_nothing([&](const fs::path& to) -> Result<void> {
      UnpackOptions options = how;
      options.output = to;
      TRY(unpack(options));
      fs::remove_all(to);
      return {};
    });
  };
  unpack_as({.input = reel(), .output = {}});
  unpack_as({.input = reel(), .output = {}, .recording = true});
  for (const bool animation : {false, true}) {
    UnpackMesh mesh;
    mesh.format = MeshFormat::glb;
    mesh.animation = animation;
    unpack_as({.input = reel(), .output = {}, .mesh = mesh});
  }
}

TEST_F(FullDiskTest, audio_names_the_file_and_leaves_the_package_as_it_is) {
  const auto before = contents(reel());
  write_wav(sound(), 48'000, 480, [](std::uint32_t n) { return n % 100 < 50 ? 0.5 : -0.5; });
  bool failed_at_sound = false, failed_at_manifest = false;
  for (rlim_t room = 0;; room += 100) {
    Result<std::optional<AudioFile>> done;
    {
      const FullDisk disk(room);
      done = replace_audio(reel(), sound());
    }
    if (done) break;
    failed_at_sound |= done.error().message.starts_with((reel() / "audio.").string());
    failed_at_manifest |= done.error().message.starts_with((reel() / kManifestName).string());
    ASSERT_EQ(contents(reel()), before) << "with " << room << " bytes";
  }
  EXPECT_TRUE(failed_at_sound);
  EXPECT_TRUE(failed_at_manifest);
  EXPECT_THAT(verify(reel())->faults, IsEmpty());
}

TEST_F(FullDiskTest, the_same_sound_again_does_not_lose_it) {
  const auto before = contents(reel());
  {
    const FullDisk disk(100);
    EXPECT_FALSE(replace_audio(reel(), sound()));
  }
  EXPECT_EQ(contents(reel()), before);
}

}  // namespace
}  // namespace pointreel::full_disk_test
