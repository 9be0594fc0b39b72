#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include <malloc.h>

#include "client/web/wasm/module.h"

// All memory of C++ comes from here, so that it can be counted, and so that a lack of it needs no
// exception.

namespace {

std::size_t in_use = 0;

void* take(std::size_t bytes) {
  void* const memory = std::malloc(bytes > 0 ? bytes : 1);
  if (memory != nullptr) in_use += malloc_usable_size(memory);
  return memory;
}

void give_back(void* memory) {
  if (memory == nullptr) return;
  in_use -= malloc_usable_size(memory);
  std::free(memory);
}

void* take_or_end(std::size_t bytes) {
  void* const memory = take(bytes);
  if (memory == nullptr) std::abort();
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) { return take_or_end(bytes); }
void* operator new[](std::size_t bytes) { return take_or_end(bytes); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept { return take(bytes); }
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept { return take(bytes); }
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete[](void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::size_t) noexcept { give_back(memory); }

void* pr_alloc(std::uint32_t bytes) { return take(bytes); }
void pr_free(void* memory) { give_back(memory); }
double pr_memory_in_use() { return static_cast<double>(in_use); }
