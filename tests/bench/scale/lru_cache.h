#pragma once

#include <cstdint>
#include <vector>

namespace pointreel::bench {

/// A cache of objects with numbers from 0 on, which drops those that were used longest ago.
class LruCache {
 public:
  /// For objects with numbers less than `objects`, and at most `capacity` bytes of them.
  LruCache(std::uint32_t objects, std::uint64_t capacity)
      : links_(objects + 1), bytes_(objects, 0), capacity_(capacity), head_(objects) {
    links_[head_] = {head_, head_};
  }

  /// Uses an object of this many bytes, which is never 0. Returns whether it was there; if not, it
  /// is fetched. Objects larger than the cache are passed through.
  bool use(std::uint32_t object, std::uint64_t bytes) {
    const bool hit = bytes_[object] > 0;
    if (hit) {
      unlink(object);
    } else {
      if (bytes > capacity_) return false;
      while (used_ + bytes > capacity_) drop(links_[head_].before);
      bytes_[object] = bytes;
      used_ += bytes;
    }
    link(object);
    return hit;
  }

 private:
  struct Link {
    std::uint32_t before, after;
  };

  void unlink(std::uint32_t object) {
    const Link link = links_[object];
    links_[link.before].after = link.after;
    links_[link.after].before = link.before;
  }
  void link(std::uint32_t object) {
    const std::uint32_t first = links_[head_].after;
    links_[object] = {head_, first};
    links_[first].before = object;
    links_[head_].after = object;
  }
  void drop(std::uint32_t object) {
    unlink(object);
    used_ -= bytes_[object];
    bytes_[object] = 0;
  }

  std::vector<Link> links_;           ///< a ring through head_, the last used object first
  std::vector<std::uint64_t> bytes_;  ///< of each object; 0: not in the cache
  std::uint64_t capacity_, used_ = 0;
  std::uint32_t head_;
};

}  // namespace pointreel::bench
