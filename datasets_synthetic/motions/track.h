#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <glm/glm.hpp>

namespace pointreel {

/// The values of a track at one time, in seconds.
template <std::size_t N>
struct Key {
  double time;
  std::array<double, N> value;
};

/// At least two keys, in order of time.
template <std::size_t N, std::size_t Keys>
using Track = std::array<Key<N>, Keys>;

/// The values of a track at `time`, interpolated by cubic curves with continuous slopes that never
/// overshoot the keys: a foot that two keys place on the same spot stays there (Fritsch, Butland,
/// "A method for constructing local monotone piecewise cubic interpolants"). Before the first key
/// and after the last one the values stay constant. If the track `loops`, its last key must equal
/// the first.
template <std::size_t N, std::size_t Keys>
std::array<double, N> at(const Track<N, Keys>& track, double time, bool loops = false) {
  static_assert(Keys >= 2);
  if (time <= track.front().time) return track.front().value;
  if (time >= track.back().time) return track.back().value;
  std::size_t i = 0;
  while (track[i + 1].time < time) ++i;
  const auto width = [&](std::size_t k) { return track[k + 1].time - track[k].time; };
  std::array<double, N> result;
  for (std::size_t n = 0; n < N; ++n) {
    const auto slope = [&](std::size_t k) {
      return (track[k + 1].value[n] - track[k].value[n]) / width(k);
    };
    const auto tangent = [&](std::size_t k) {
      if (!loops && (k == 0 || k == Keys - 1)) return 0.0;
      const std::size_t before = k == 0 ? Keys - 2 : k - 1, after = k == Keys - 1 ? 0 : k;
      const double left = slope(before), right = slope(after);
      if (left * right <= 0.0) return 0.0;
      const double a = width(before) + 2.0 * width(after), b = 2.0 * width(before) + width(after);
      return (a + b) / (b / left + a / right);
    };
    const double h = width(i), s = (time - track[i].time) / h;
    const double from = track[i].value[n], to = track[i + 1].value[n];
    const double ease = s * s * (3.0 - 2.0 * s);
    result[n] = from + (to - from) * ease + h * s * (1.0 - s) * (1.0 - s) * tangent(i) -
                h * s * s * (1.0 - s) * tangent(i + 1);
  }
  return result;
}

inline glm::dvec3 vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// 0 up to `from`, 1 from `to` on, and a smooth rise between them.
inline double rise(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

inline double fraction(double x) { return x - std::floor(x); }

}  // namespace pointreel
