// Gives libFuzzer the target that the first argument names. Its own options follow:
//   pointreel_fuzz ply tests/fuzz/corpus/ply -max_total_time=60

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "common/process/print.h"
#include "tests/fuzz/target.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace pointreel::fuzz {
namespace {

/// Tells the processes that libFuzzer starts by itself, as for -fork and -merge, the target.
constexpr const char* kTargetVariable = "POINTREEL_FUZZ_TARGET";

const Target* target = nullptr;

[[noreturn]] void refuse(const std::string& name) {
  std::string names;
  for (const auto& [each, unused] : targets()) names.append(" ").append(each);
  print_error("pointreel_fuzz", name.empty() ? "the first argument is a target, one of:" + names
                                             : name + " is not a target; they are:" + names);
  std::exit(2);
}

}  // namespace

void choose_target(int& argc, char**& argv) {
  static std::vector<std::string> options;
  static std::vector<char*> arguments(argv, argv + argc);
  std::string name;
  if (const char* inherited = std::getenv(kTargetVariable)) {
    name = inherited;
  } else if (argc > 1) {
    name = argv[1];
    arguments.erase(arguments.begin() + 1);
    setenv(kTargetVariable, argv[1], 1);
  }
  const auto found = targets().find(name);
  if (found == targets().end()) refuse(name);
  target = &found->second;
  // AddressSanitizer keeps 256 MiB of what was freed, and no decoder here may take more than that.
  options = {"-rss_limit_mb=768", "-malloc_limit_mb=256", "-timeout=2",
             "-max_len=" + std::to_string(target->longest)};
  // libFuzzer leaves this out because of the mutator below, which most targets do not need.
  if (!target->repeats) options.push_back("-len_control=100");
  for (std::string& option : options) arguments.insert(arguments.begin() + 1, option.data());
  argc = static_cast<int>(arguments.size());
  argv = arguments.data();
}

}  // namespace pointreel::fuzz

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  pointreel::fuzz::choose_target(*argc, *argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  pointreel::fuzz::target->run({data, size});
  return 0;
}

/// For some targets, and in addition to libFuzzer's own changes, repeats a short part of the input
/// up to as often as fits. Texts that take a time out of proportion to their length are mostly of
/// this kind, and changes of a few bytes at a time never arrive at them.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  std::minstd_rand random(seed);
  if (!pointreel::fuzz::target->repeats || size == 0 || size >= max_size || random() % 8 != 0) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  const std::size_t at = random() % size;
  const std::size_t part = std::min<std::size_t>(1 + random() % 16, size - at);
  const std::size_t most = (max_size - size) / part;
  const std::size_t times = random() % 4 == 0 ? most : std::min<std::size_t>(most, random() % 1000);
  const std::size_t added = times * part;
  std::memmove(data + at + added, data + at, size - at);
  for (std::size_t i = 0; i < added; ++i) data[at + i] = data[at + added + i % part];
  return size + added;
}
