#include "tests/alloc/heap.h"

#include <atomic>
#include <cstdlib>
#include <new>

#include <malloc.h>

namespace {

std::atomic<std::size_t> used{0}, most{0};
/// Allocations up to the one that fails; 0 if none is to fail.
std::atomic<std::size_t> left{0};

bool is_to_fail() {
  std::size_t now = left.load();
  while (now > 0 && !left.compare_exchange_weak(now, now - 1)) {
  }
  return now == 1;
}

void* note(void* memory) {
  if (memory == nullptr) return nullptr;
  const std::size_t now = used += malloc_usable_size(memory);
  std::size_t before = most.load();
  while (before < now && !most.compare_exchange_weak(before, now)) {
  }
  return memory;
}

void* allocate(std::size_t size, std::size_t alignment) {
  if (is_to_fail()) return nullptr;
  if (alignment <= alignof(std::max_align_t)) return note(std::malloc(size));
  return note(std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment));
}

void* allocate_or_throw(std::size_t size, std::size_t alignment) {
  void* const memory = allocate(size, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void release(void* memory) {
  if (memory == nullptr) return;
  used -= malloc_usable_size(memory);
  std::free(memory);
}

constexpr std::size_t kPlain = alignof(std::max_align_t);

}  // namespace

// The other forms of new and delete call these.
void* operator new(std::size_t size) { return allocate_or_throw(size, kPlain); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate_or_throw(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, kPlain);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, kPlain);
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace pointreel::heap {

std::size_t in_use() { return used; }

Peak::Peak() : before_(used) { most = before_; }
std::size_t Peak::bytes() const { return most - before_; }

Failure::Failure(std::size_t nth) { left = nth; }
Failure::~Failure() { left = 0; }
bool Failure::happened() const { return left == 0; }

}  // namespace pointreel::heap
