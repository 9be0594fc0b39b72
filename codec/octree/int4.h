#pragma once

#include <cstdint>
#include <cstring>

/// Four integers in one vector: the three components of an attribute, and a lane for other uses.
/// The vector extensions of GCC and Clang work on all processors, and in WebAssembly.
namespace pointreel {

typedef std::int32_t Int4 __attribute__((vector_size(16)));

/// The stored form of an Int4 whose lanes fit into 16 bits.
struct Short4 {
  std::int16_t lanes[4];
};

inline Int4 load(const Short4& value) {
  typedef std::int16_t Short8 __attribute__((vector_size(16)));
  std::int64_t four;
  std::memcpy(&four, value.lanes, sizeof(four));
  typedef std::int64_t Long2 __attribute__((vector_size(16)));
  const auto lanes = reinterpret_cast<Short8>(Long2{four, 0});
  // Each number is doubled and shifted down, since g++ 12 needs more instructions for
  // __builtin_convertvector.
  const Short8 twice = __builtin_shufflevector(lanes, lanes, 0, 0, 1, 1, 2, 2, 3, 3);
  return reinterpret_cast<Int4>(twice) >> 16;
}

inline Short4 narrow(const Int4& value) {
  typedef std::int16_t Vector __attribute__((vector_size(8)));
  const Vector vector = __builtin_convertvector(value, Vector);
  Short4 stored;
  std::memcpy(stored.lanes, &vector, sizeof(vector));
  return stored;
}

inline Int4 broadcast(std::int32_t v) { return Int4{v, v, v, v}; }

inline Int4 min(const Int4& a, const Int4& b) { return a < b ? a : b; }
inline Int4 max(const Int4& a, const Int4& b) { return a > b ? a : b; }
inline Int4 clamp(const Int4& v, std::int32_t least, std::int32_t most) {
  return min(max(v, broadcast(least)), broadcast(most));
}
inline Int4 abs(const Int4& v) { return max(v, -v); }

}  // namespace pointreel
