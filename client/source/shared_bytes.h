#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>

#include "pointreel/bytes.h"

namespace pointreel {

/// Bytes that do not change any more and that several holders share: copying this copies none of
/// them. A part of them keeps all of them in memory.
class SharedBytes {
 public:
  using const_iterator = ByteView::iterator;

  SharedBytes() = default;
  /// Implicit, so that functions can return Bytes where shared ones are expected.
  SharedBytes(Bytes bytes) : all_(std::make_shared<const Bytes>(std::move(bytes))), part_(*all_) {}

  /// offset + size <= this->size().
  SharedBytes part(std::size_t offset, std::size_t size) const {
    SharedBytes shared = *this;
    shared.part_ = part_.subspan(offset, size);
    return shared;
  }

  ByteView view() const { return part_; }
  std::size_t size() const { return part_.size(); }
  bool empty() const { return part_.empty(); }
  const_iterator begin() const { return part_.begin(); }
  const_iterator end() const { return part_.end(); }

  /// Whether they hold the same bytes, shared or not.
  friend bool operator==(const SharedBytes& a, const SharedBytes& b) {
    return std::ranges::equal(a.part_, b.part_);
  }

 private:
  std::shared_ptr<const Bytes> all_;
  ByteView part_;
};

}  // namespace pointreel
