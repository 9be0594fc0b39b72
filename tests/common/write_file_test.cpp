#include "common/file_system/write_file.h"

#include <filesystem>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/full_disk.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"

namespace pointreel::write_file_test {
namespace {

namespace fs = std::filesystem;

class WriteFile : public testing::Test {
 protected:
  bool is_empty() const { return fs::is_empty(folder_.path()); }
  fs::path file() const { return folder_ / "a.txt"; }

  const TemporaryFolder folder_;
  const std::string long_text_ = std::string(20'000, 'x');
};

TEST_F(WriteFile, leaves_no_part_of_a_file_on_a_full_disk) {
  for (const rlim_t room : {0, 10'000}) {
    Result<void> written;
    {
      const FullDisk disk(room);
      written = write_file(file(), long_text_);
    }
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().message, file().string() + ": cannot be written: File too large");
    EXPECT_TRUE(is_empty());
  }
}

TEST_F(WriteFile, does_not_remove_a_device) {
  // A name of its own for the device that is always full.
  fs::create_symlink("/dev/full", file());
  const auto written = write_file(file(), long_text_);
  ASSERT_FALSE(written);
  EXPECT_EQ(
      written.error().message,
      file().string() + ": cannot be written: No space left on device; make room on the disk");
  EXPECT_TRUE(fs::is_symlink(file()));
}

TEST_F(WriteFile, does_not_wait_for_whoever_might_read_a_pipe) {
  ASSERT_EQ(::mkfifo(file().c_str(), 0600), 0);
  const auto nobody = write_file(file(), "text");
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().message, file().string() + ": cannot be written: no program reads it");
  EXPECT_TRUE(fs::is_fifo(file()));
  const int reader = ::open(file().c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  EXPECT_TRUE(write_file(file(), "text"));
  char text[8] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 4);
  ::close(reader);
}

TEST_F(WriteFile, replaces_a_file_only_by_a_whole_one) {
  ASSERT_TRUE(write_file(file(), std::string("before")));
  {
    const FullDisk disk(10'000);
    EXPECT_EQ(replace_file(file(), long_text_).error().message,
              file().string() + ": cannot be written: File too large");
  }
  EXPECT_EQ(read_file(file()), "before");
  ASSERT_TRUE(replace_file(file(), long_text_));
  EXPECT_EQ(read_file(file()), long_text_);
  fs::remove(file());
  EXPECT_TRUE(is_empty()) << "nothing else has stayed";
}

}  // namespace
}  // namespace pointreel::write_file_test
