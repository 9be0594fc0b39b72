#pragma once

#include <algorithm>
#include <cstddef>

#include "common/base/for_each.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Consecutive items, divided into blocks of about the same size for the threads of an executor.
class Blocks {
 public:
  /// `least`: fewer items are not worth a block of their own. There is one block without an
  /// executor.
  Blocks(const Executor& executor, std::size_t items, std::size_t least)
      : items_(items), count_(executor ? std::clamp<std::size_t>(items / least, 1, kMost) : 1) {}

  std::size_t count() const { return count_; }
  std::size_t begin(std::size_t block) const { return items_ * block / count_; }
  std::size_t end(std::size_t block) const { return begin(block + 1); }

 private:
  /// Enough for any number of threads, and few enough that what is kept for each does not count.
  static constexpr std::size_t kMost = 64;
  std::size_t items_, count_;
};

/// Calls body(block, begin, end) for each block, as for_each does. Static for the same reason.
template <class Body>
static inline void for_each_block(const Executor& executor, const Blocks& blocks,
                                  const Body& body) {
  if (blocks.count() == 1) {
    body(std::size_t{0}, blocks.begin(0), blocks.end(0));
    return;
  }
  for_each(executor, static_cast<int>(blocks.count()), [&](int i) {
    const auto block = static_cast<std::size_t>(i);
    body(block, blocks.begin(block), blocks.end(block));
  });
}

}  // namespace pointreel
