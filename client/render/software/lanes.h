#pragma once

#include <cstring>

#include "codec/surface/lanes.h"

namespace pointreel {

/// Kernels are compiled once for every processor and once for those with AVX2. Everything that they
/// call must be inlined to be compiled for the right one: the two return Lanes in different
/// registers. The second form is for lambdas, before their braces.
#define POINTREEL_INLINE [[gnu::always_inline]] inline
#define POINTREEL_INLINED __attribute__((always_inline))
#if defined(__x86_64__)
#define POINTREEL_AVX2 __attribute__((target("avx2")))
#else
#define POINTREEL_AVX2
#endif

POINTREEL_INLINE void load(Lanes& to, const float* from) { std::memcpy(&to, from, sizeof(to)); }
POINTREEL_INLINE void store(float* to, const Lanes& from) { std::memcpy(to, &from, sizeof(from)); }

POINTREEL_INLINE Lanes max_of(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
POINTREEL_INLINE Lanes min_of(const Lanes& a, const Lanes& b) { return a < b ? a : b; }

inline constexpr Lanes kIota = {0, 1, 2, 3, 4, 5, 6, 7};

}  // namespace pointreel
