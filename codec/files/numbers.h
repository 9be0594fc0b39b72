#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace pointreel {

/// The types of numbers in files of points.
enum class NumberType : std::uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

/// In bytes: 1, 2, 4 or 8.
constexpr std::size_t size_of(NumberType type) {
  constexpr std::array<std::size_t, 10> kSizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

constexpr bool is_float(NumberType type) { return type >= NumberType::float32; }

/// The number of type T at `at`, which need not be aligned.
template <class T, bool kSwapped = false>
T load_number(const std::uint8_t* at) {
  std::array<std::uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if constexpr (kSwapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Calls `f` with a value of the C++ type that corresponds to `type`.
template <class F>
auto with_number_type(NumberType type, F&& f) {
  switch (type) {
    case NumberType::int8:
      return f(std::int8_t{});
    case NumberType::uint8:
      return f(std::uint8_t{});
    case NumberType::int16:
      return f(std::int16_t{});
    case NumberType::uint16:
      return f(std::uint16_t{});
    case NumberType::int32:
      return f(std::int32_t{});
    case NumberType::uint32:
      return f(std::uint32_t{});
    case NumberType::int64:
      return f(std::int64_t{});
    case NumberType::uint64:
      return f(std::uint64_t{});
    case NumberType::float32:
      return f(float{});
    default:
      return f(double{});
  }
}

/// Stores a number as the type has it: rounded to float, or cut off to a whole number that the type
/// can hold. NaN becomes 0 there.
inline void store_number(NumberType type, double value, std::uint8_t* at) {
  with_number_type(type, [=](auto t) {
    using T = decltype(t);
    T stored{};
    if constexpr (std::is_floating_point_v<T>) {
      stored = static_cast<T>(value);
    } else {
      // The largest number of 64 bits is no double, but the next one is.
      constexpr double kLow = static_cast<double>(std::numeric_limits<T>::min());
      constexpr double kEnd = static_cast<double>(std::numeric_limits<T>::max() / 2 + 1) * 2.0;
      if (value >= kEnd) {
        stored = std::numeric_limits<T>::max();
      } else if (value > kLow) {
        stored = static_cast<T>(value);
      } else if (value <= kLow) {
        stored = std::numeric_limits<T>::min();
      }
    }
    std::memcpy(at, &stored, sizeof(T));
  });
}

}  // namespace pointreel
