#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// In addition to libFuzzer's own changes, repeats a short part of the input up to as often as
/// fits. Texts that take a time out of proportion to their length are mostly of this kind, and
/// changes of a few bytes at a time never arrive at them. Include this in one file of a fuzzer.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  std::minstd_rand random(seed);
  if (size == 0 || size >= max_size || random() % 8 != 0) {
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
