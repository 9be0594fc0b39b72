#pragma once

#include <cstddef>

/// Replaces operator new of the whole program, libraries included, by one that counts, and that can
/// be made to fail.
namespace pointreel::heap {

/// The bytes that are allocated now, by all threads.
std::size_t in_use();

/// Notes the most bytes that are in use at any time while it lives, beyond those in use before.
class Peak {
 public:
  Peak();
  std::size_t bytes() const;

 private:
  std::size_t before_;
};

/// While it lives, the allocation number `nth`, counted from 1, fails, and all others succeed.
class Failure {
 public:
  explicit Failure(std::size_t nth);
  ~Failure();
  Failure(const Failure&) = delete;
  Failure& operator=(const Failure&) = delete;
  /// False if there were fewer allocations.
  bool happened() const;
};

}  // namespace pointreel::heap
