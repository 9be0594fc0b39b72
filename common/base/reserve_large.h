#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace pointreel {

/// Reserves memory for an array, in large pages where the system has such. It takes longer to get
/// the small pages of a large array than to read a file into it.
template <class T>
void reserve_large(std::vector<T>& array, std::size_t size) {
  array.reserve(size);
#ifdef __linux__
  constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
  const auto at = reinterpret_cast<std::uintptr_t>(array.data());
  const std::uintptr_t begin = (at + kPage - 1) / kPage * kPage;
  const std::uintptr_t end = (at + size * sizeof(T)) / kPage * kPage;
  // Only advice, so it does not matter if it is not taken.
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

}  // namespace pointreel
