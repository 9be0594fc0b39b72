#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/words.h"

namespace pointreel {

/// What the values of a scalar field lose as floats: much, if they are large and differ little, as
/// times since 1970 and numbers of points do.
class ScalarLoss {
 public:
  /// `exact`: floats hold all values of the type.
  explicit ScalarLoss(bool exact) : exact_(exact) {}

  void see(double value) {
    if (exact_ || !std::isfinite(value)) return;
    least_ = std::min(least_, value);
    most_ = std::max(most_, value);
    loss_ = std::max(loss_, std::abs(value - static_cast<double>(static_cast<float>(value))));
  }

  /// A line about it, if more is lost than by coding in 255 steps. Of a field that is the same
  /// everywhere, nothing can be told apart that would be lost.
  std::optional<std::string> warning(std::string_view name) const {
    constexpr double kSteps = 255.0;
    if (!(loss_ > 0.0) || !(most_ > least_) || loss_ <= 0.5 * (most_ - least_) / kSteps)
      return std::nullopt;
    return concat("the scalar field ", printable(name), ", from ", number_text(least_, 12), " to ",
                  number_text(most_, 12), ", is off by up to ", number_text(loss_, 3),
                  ", because it is kept in 32 bits: subtract an offset from it before");
  }

 private:
  bool exact_;
  double least_ = std::numeric_limits<double>::infinity(), most_ = -least_, loss_ = 0.0;
};

}  // namespace pointreel
