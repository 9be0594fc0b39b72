#pragma once

#include <cstdint>
#include <string>

#include "pointreel/error.h"

namespace pointreel {

/// A file name with a place for a number, such as "out-%04d.png": exactly one %d, %Nd or %0Nd with
/// N up to 20, and %% for a percent sign. The pattern is never passed to printf.
class NumberedPath {
 public:
  /// Fails with ErrorCode::argument if the pattern is not of this form.
  static Result<NumberedPath> parse(const std::string& pattern);

  std::string at(std::uint64_t number) const;

  /// The path with the smallest number, from 1 on, where no file exists.
  std::string first_free() const;

 private:
  std::string before_, after_;
  std::size_t width_ = 0;
  char fill_ = ' ';
};

}  // namespace pointreel
