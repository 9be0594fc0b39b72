// Puts large blocks of memory onto huge pages, where the system leaves that to programs (the
// setting "madvise" of transparent_hugepage, which many distributions have). Clouds and pictures
// take gigabytes that are written once, and a fault for each 4 KiB of them takes up to 30 % of the
// time of packing. Programs only: a library must not replace the allocation of others.
#include <cstddef>
#include <cstdlib>
#include <new>

#include <sys/mman.h>

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
/// Smaller blocks would waste much of their last page.
constexpr std::size_t kLarge = 2 * kHugePage;
/// Rounded up to huge pages, more than this is not a size.
constexpr std::size_t kMost = ~std::size_t{0} / 2;

void* allocate(std::size_t size) {
  if (size < kLarge || size > kMost) return std::malloc(size > 0 ? size : 1);
  const std::size_t whole = (size + kHugePage - 1) / kHugePage * kHugePage;
  void* const block = std::aligned_alloc(kHugePage, whole);
  // Without huge pages it is slower, and nothing else.
  if (block != nullptr) ::madvise(block, whole, MADV_HUGEPAGE);
  return block;
}

}  // namespace

void* operator new(std::size_t size) {
  for (;;) {
    if (void* const block = allocate(size)) return block;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
