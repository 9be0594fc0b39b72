#pragma once

#include <cmath>
#include <cstdint>

#include "codec/octree/int4.h"

namespace pointreel {

/// Turns differences of normals so that the third component is that along a node's own normal,
/// which is mostly small: by the reflection that takes the normal to an axis (A. Householder,
/// "Unitary triangularization of a nonsymmetric matrix", 1958), in integers. Reflecting twice gives
/// nearly the same again. FORMAT.md, "Tangent frame".
class TangentFrame {
 public:
  /// `normal`: the value of a node. A short one has no frame, and differences stay as they are.
  explicit TangentFrame(const Int4& normal) {
    constexpr std::int32_t kLeastLength = 512;
    const std::int32_t squared =
        normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    if (squared < kLeastLength * kLeastLength) return;
    const auto length = static_cast<std::int32_t>(std::sqrt(static_cast<double>(squared)));
    axis_ = Int4{normal[0], normal[1], normal[2] < 0 ? normal[2] - length : normal[2] + length, 0};
    const std::int64_t of_axis = std::int64_t{axis_[0]} * axis_[0] +
                                 std::int64_t{axis_[1]} * axis_[1] +
                                 std::int64_t{axis_[2]} * axis_[2];
    inverse_ = (std::int64_t{1} << 45) / of_axis;
  }

  /// Differences are at most 2^17.
  Int4 reflect(const Int4& d) const {
    const std::int64_t along = std::int64_t{axis_[0]} * d[0] + std::int64_t{axis_[1]} * d[1] +
                               std::int64_t{axis_[2]} * d[2];
    const std::int64_t twice = (along * inverse_) >> 30;
    return Int4{d[0] - static_cast<std::int32_t>((axis_[0] * twice) >> 14),
                d[1] - static_cast<std::int32_t>((axis_[1] * twice) >> 14),
                d[2] - static_cast<std::int32_t>((axis_[2] * twice) >> 14), 0};
  }

 private:
  Int4 axis_{};
  std::int64_t inverse_ = 0;
};

}  // namespace pointreel
