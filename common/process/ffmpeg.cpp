#include "common/process/ffmpeg.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace pointreel {
namespace {

/// The first message in the file, without the component and the address at its beginning, such as
/// "[libx264 @ 0x55d0] ".
std::string first_line(int file) {
  std::array<char, 1024> buffer;
  const ssize_t size = pread(file, buffer.data(), buffer.size(), 0);
  std::string text(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(0, size)));
  text.resize(std::min(text.find_first_of("\r\n"), text.size()));
  if (const std::size_t end = text.find("] "); text.starts_with('[') && end != std::string::npos)
    text.erase(0, end + 2);
  for (char& c : text)
    if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
  return text;
}

void connect(posix_spawn_file_actions_t& files, int file, int as, int flags) {
  if (file >= 0) {
    posix_spawn_file_actions_adddup2(&files, file, as);
  } else {
    posix_spawn_file_actions_addopen(&files, as, "/dev/null", flags, 0);
  }
}

}  // namespace

bool is_installed(const std::string& program) {
  const auto executable = [](const std::filesystem::path& file) {
    std::error_code none;
    return std::filesystem::is_regular_file(file, none) && access(file.c_str(), X_OK) == 0;
  };
  if (program.find('/') != std::string::npos) return executable(program);
  const char* path = std::getenv("PATH");
  std::string_view folders = path != nullptr ? path : "/bin:/usr/bin";
  while (!folders.empty()) {
    const std::size_t end = std::min(folders.find(':'), folders.size());
    if (executable(std::filesystem::path(folders.substr(0, end)) / program)) return true;
    folders.remove_prefix(std::min(end + 1, folders.size()));
  }
  return false;
}

Result<Ffmpeg> Ffmpeg::start(const std::vector<std::string>& arguments, const Files& given,
                             const std::string& program) {
  std::vector<std::string> words = {program, "-hide_banner", "-loglevel", "error"};
  if (program != "ffprobe") words.emplace_back("-nostdin");  // which ffprobe does not know
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  Ffmpeg ffmpeg(-1, memfd_create("ffmpeg", MFD_CLOEXEC));
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  connect(files, given.input, STDIN_FILENO, O_RDONLY);
  connect(files, given.output, STDOUT_FILENO, O_WRONLY);
  connect(files, ffmpeg.messages_, STDERR_FILENO, O_WRONLY);
  // The last of them, since any of the files before may be number 3 here.
  connect(files, given.second_input, STDERR_FILENO + 1, O_RDONLY);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 2);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t process = -1;
  const int failed =
      posix_spawnp(&process, program.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (failed == ENOENT) return fail(ErrorCode::not_found, program + " is not installed");
  if (failed != 0) return fail(ErrorCode::io, program + ": cannot be run: " + strerror(failed));
  ffmpeg.process_ = process;
  return ffmpeg;
}

Ffmpeg::Ffmpeg(Ffmpeg&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      messages_(std::exchange(other.messages_, -1)),
      status_(other.status_) {}

Ffmpeg::~Ffmpeg() {
  kill();
  wait();
  if (messages_ >= 0) close(messages_);
}

void Ffmpeg::kill() const {
  if (process_ >= 0) ::kill(process_, SIGKILL);
}

bool Ffmpeg::wait() {
  if (process_ >= 0) {
    while (waitpid(process_, &status_, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
  }
  return status_ == 0;
}

std::string Ffmpeg::said() const {
  std::array<char, 4096> buffer;
  const ssize_t size = pread(messages_, buffer.data(), buffer.size(), 0);
  return {buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(0, size))};
}

std::string Ffmpeg::reason() const {
  std::string why = messages_ >= 0 ? first_line(messages_) : "";
  if (why.empty() && WIFSIGNALED(status_)) why = strsignal(WTERMSIG(status_));
  return why;
}

}  // namespace pointreel
