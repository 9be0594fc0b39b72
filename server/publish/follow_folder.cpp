#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "codec/files/cloud_format.h"
#include "common/base/natural_order.h"
#include "common/base/try.h"
#include "common/file_system/descriptor.h"
#include "common/file_system/open_file.h"
#include "server/publish/frame_input.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

bool is_link(const fs::path& path) {
  std::error_code ignored;
  return fs::is_symlink(fs::symlink_status(path, ignored)) ||
         fs::hard_link_count(path, ignored) > 1;
}

class FolderFollower : public FrameInput {
 public:
  FolderFollower(fs::path folder, int watch, LiveClock clock, Reading asked,
                 std::uint64_t max_memory)
      : folder_(std::move(folder)),
        watch_(watch),
        clock_(std::move(clock)),
        reading_(std::move(asked)),
        max_memory_(max_memory) {
    for_each_file([this](const std::string& name) {
      if (!is_of_points(newest_) || natural_less(newest_, name)) newest_ = name;
    });
    taken_ = time_of(folder_ / newest_);
  }
  ~FolderFollower() override { ::close(watch_); }

  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    for (;;) {
      read_events();
      if (!newest_.empty()) break;
      if (gone_)
        return fail(ErrorCode::io,
                    folder_.string() + ": was removed or renamed while it was followed");
      if (!wait_readable(watch_, stop)) return std::optional<InputFrame>();
    }
    taken_name_ = std::exchange(newest_, {});
    const fs::path file = folder_ / taken_name_;
    taken_ = time_of(file);
    skipped_when_taken_ = skipped_;
    const std::uint64_t now = clock_.now_us();
    return InputFrame{file.string(), now, read(file)};
  }

  std::uint64_t skipped() const override { return skipped_; }

 private:
  /// A pipe that somebody put there would be waited for.
  Result<LoadedCloud> read(const fs::path& file) {
    TRY(at_place(file.string(), OpenFile::open(file)));
    return read_next_cloud_file(file, reading_, {.max_memory = max_memory_});
  }

  /// Whether a file of this name is a frame. Names such as notes.txt may be anything, and count
  /// only as long as the folder has had no file that is clearly of points (list_cloud_files).
  bool is_of_points(const std::string& name) {
    const Likely likely = name.starts_with('.') ? Likely::no : is_cloud_name(name);
    if (likely == Likely::yes) sure_names_ = true;
    return likely == Likely::yes || (likely == Likely::maybe && !sure_names_);
  }

  /// Calls `visit` for each frame that is in the folder.
  template <class Visit>
  void for_each_file(const Visit& visit) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
      const std::string name = entry.path().filename().string();
      if (is_of_points(name)) visit(name);
    }
  }

  static fs::file_time_type time_of(const fs::path& file) {
    std::error_code ignored;
    return fs::last_write_time(file, ignored);
  }

  /// Finds the newest file after events were lost, and counts those since the last that was taken.
  void look_again() {
    fs::file_time_type newest = taken_;
    std::uint64_t files = 0;
    for_each_file([&](const std::string& name) {
      const fs::file_time_type time = time_of(folder_ / name);
      if (time < taken_ || name == taken_name_) return;
      ++files;
      if (time < newest || (time == newest && !natural_less(newest_, name))) return;
      newest = time;
      newest_ = name;
    });
    skipped_ = std::max(skipped_, skipped_when_taken_ + std::max<std::uint64_t>(files, 1) - 1);
  }

  /// Reads the events that the system holds ready, without waiting.
  void read_events() {
    alignas(inotify_event) std::array<char, 16 * 1024> events;
    bool lost = false;  // the system holds no more than some thousands
    for (;;) {
      const ssize_t size = ::read(watch_, events.data(), events.size());
      if (size <= 0) return lost ? look_again() : void();
      for (ssize_t at = 0; at < size;) {
        const auto* event = reinterpret_cast<const inotify_event*>(events.data() + at);
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
        const std::string name = event->len > 0 ? event->name : "";
        if (event->mask & IN_Q_OVERFLOW) lost = true;
        if (event->mask & (IN_DELETE_SELF | IN_MOVE_SELF | IN_UNMOUNT)) gone_ = true;
        if (!is_of_points(name)) continue;
        // A file that is created will be written; a link is complete.
        if (event->mask & IN_CREATE && !is_link(folder_ / name)) continue;
        if (!newest_.empty() && newest_ != name) ++skipped_;
        newest_ = name;
      }
    }
  }

  const fs::path folder_;
  const int watch_;
  const LiveClock clock_;
  Reading reading_;
  const std::uint64_t max_memory_;
  std::string newest_;  ///< not taken yet; empty if there is none
  std::uint64_t skipped_ = 0;
  std::string taken_name_;    ///< of the last file that was taken; empty if there is none
  fs::file_time_type taken_;  ///< when that, or before it the newest of all, was written
  std::uint64_t skipped_when_taken_ = 0;
  bool sure_names_ = false;  ///< there was a file that is clearly of points
  bool gone_ = false;        ///< the folder is no longer at its place
};

}  // namespace

Result<std::unique_ptr<FrameInput>> follow_folder(const fs::path& folder, LiveClock clock,
                                                  Reading asked, std::uint64_t max_memory) {
  const int watch = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (watch < 0 || ::inotify_add_watch(watch, folder.c_str(),
                                       IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE | IN_DELETE_SELF |
                                           IN_MOVE_SELF | IN_ONLYDIR) < 0) {
    const std::string message = errno_message();
    if (watch >= 0) ::close(watch);
    return fail(ErrorCode::io, fmt::format("{}: cannot be followed: {}", folder.string(), message));
  }
  return std::make_unique<FolderFollower>(folder, watch, std::move(clock), std::move(asked),
                                          max_memory);
}

}  // namespace pointreel
