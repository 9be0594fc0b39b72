#include "client/render/software/picture.h"

#include <cmath>

#include "client/render/srgb.h"

namespace pointreel {

SrgbTables::SrgbTables() {
  for (std::size_t i = 0; i < bytes_.size(); ++i) {
    const double linear = static_cast<double>(i) / kSteps;
    bytes_[i] = static_cast<std::uint8_t>(std::lround(255.0 * srgb_from_linear(linear)));
  }
  for (std::size_t i = 0; i < linear_.size(); ++i)
    linear_[i] = static_cast<float>(linear_from_srgb(static_cast<double>(i) / 255.0));
}

const SrgbTables& SrgbTables::get() {
  static const SrgbTables tables;
  return tables;
}

}  // namespace pointreel
