// Tries every target with the files of its corpus, whole and cut, so that any compiler's build does
// what the fuzzers found to be worth trying:
//   pointreel_corpus tests/fuzz/corpus

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/process/print.h"
#include "tests/fuzz/target.h"
#include "tests/read_file.h"

namespace pointreel::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "pointreel_corpus";
/// A file is cut at each of this many places, from its beginning on.
constexpr std::size_t kCuts = 8;

/// Where a process is, in memory that its parent reads after a crash.
struct Progress {
  std::size_t file = 0;
  std::size_t size = 0;  // of what is left of the file
  std::size_t inputs = 0;
};

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code missing;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, missing))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void try_files(const Target& target, const std::vector<fs::path>& files, Progress& progress) {
  for (; progress.file < files.size(); ++progress.file) {
    const std::string whole = read_file(files[progress.file]);
    for (std::size_t part = 0; part <= kCuts; ++part) {
      progress.size = whole.size() * part / kCuts;
      const std::string_view left = std::string_view(whole).substr(0, progress.size);
      // Memory of just this size, so that sanitizers notice reading past its end.
      target.run(Bytes(left.begin(), left.end()));
      ++progress.inputs;
    }
  }
}

/// Tries the files in a process of its own, which a fault ends. False, after naming the file, if it
/// did.
bool replay(std::string_view name, const Target& target, const std::vector<fs::path>& files,
            Progress& progress) {
  progress = {};
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    try_files(target, files, progress);
    std::exit(0);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) {
    print_error(kProgram, fmt::format("cannot start a process: {}", std::strerror(errno)));
    return false;
  }
  if (status == 0) {
    print("{}: {} files, {} inputs\n", name, files.size(), progress.inputs);
    return true;
  }
  const std::string how = WIFSIGNALED(status) ? strsignal(WTERMSIG(status))
                                              : fmt::format("status {}", WEXITSTATUS(status));
  print_error(kProgram, progress.file < files.size()
                            ? fmt::format("{} fails ({}) with the first {} bytes of {}", name, how,
                                          progress.size, files[progress.file].string())
                            : fmt::format("{} fails ({}) after its last file", name, how));
  return false;
}

bool replay_all(const fs::path& corpora) {
  void* const shared =
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) {
    print_error(kProgram, fmt::format("cannot share memory: {}", std::strerror(errno)));
    return false;
  }
  Progress& progress = *static_cast<Progress*>(shared);
  bool good = true;
  for (const auto& [name, target] : targets()) {
    const std::vector<fs::path> files = files_in(corpora / name);
    if (files.empty()) {
      print_error(kProgram, fmt::format("target {} has no files in {}", name, corpora.string()));
      good = false;
    } else if (!replay(name, target, files, progress)) {
      good = false;
    }
  }
  for (const fs::path& folder : files_in(corpora)) {
    if (targets().contains(folder.filename().string())) continue;
    print_error(kProgram, fmt::format("there is no target for {}", folder.string()));
    good = false;
  }
  return good;
}

}  // namespace
}  // namespace pointreel::fuzz

int main(int argc, char** argv) {
  if (argc != 2) {
    pointreel::print_error(pointreel::fuzz::kProgram,
                           "the only argument is the folder of the corpora");
    return 2;
  }
  return pointreel::fuzz::replay_all(argv[1]) ? 0 : 1;
}
