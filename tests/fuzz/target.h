#pragma once

#include <cstddef>
#include <cstdlib>
#include <map>
#include <string_view>

#include "pointreel/bytes.h"

/// What hostile input is tried with: parsers, decoders, and what reads their output. Each has a
/// file NAME_fuzz.cpp and a folder corpus/NAME.
namespace pointreel::fuzz {

struct Target {
  void (*run)(ByteView input);  ///< Ends the program if something is wrong.
  std::size_t longest = 4096;   ///< the most bytes that libFuzzer makes an input of
  bool repeats = false;         ///< libFuzzer also repeats parts of inputs: see libfuzzer.cpp
};

/// All targets, by name.
inline std::map<std::string_view, Target>& targets() {
  static std::map<std::string_view, Target> all;
  return all;
}

inline bool add_target(std::string_view name, Target target) {
  return targets().emplace(name, target).second;
}

inline void require(bool condition) {
  if (!condition) std::abort();
}

/// What messages of errors are.
inline bool one_line(std::string_view text) {
  return !text.empty() && text.find('\n') == std::string_view::npos;
}

inline std::string_view as_text(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace pointreel::fuzz

/// Begins the function that a target is, whose argument is `input`:
///
///   FUZZ_TARGET(reel, .longest = 1 << 20, .repeats = true) { ... }
///
/// What only this target needs stands in pointreel::fuzz::reel, because the files are compiled
/// together.
#define FUZZ_TARGET(name, ...)                                                    \
  namespace pointreel::fuzz::name {                                               \
  void run(ByteView input);                                                       \
  const bool kAdded = add_target(#name, {.run = run __VA_OPT__(, ) __VA_ARGS__}); \
  }                                                                               \
  void pointreel::fuzz::name::run(ByteView input)
