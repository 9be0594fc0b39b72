#include "tests/bench/training/things.h"

#include <algorithm>
#include <cmath>

#include "datasets_synthetic/trigonometry.h"

namespace pointreel::bench {

SampledSurface sample_thing(const std::vector<ThingPart>& parts, std::size_t count,
                            Random& random) {
  const auto inside = [](const ThingPart& part, const glm::dvec3& p) {
    constexpr double kMargin = 1e-9;
    if (part.radius == 0.0) {
      return glm::all(glm::greaterThan(p, part.from + kMargin)) &&
             glm::all(glm::lessThan(p, part.to - kMargin));
    }
    const glm::dvec3 axis = part.to - part.from;
    const double t =
        std::clamp(glm::dot(p - part.from, axis) / std::max(glm::dot(axis, axis), 1e-12), 0.0, 1.0);
    const glm::dvec3 d = p - (part.from + t * axis);
    return glm::dot(d, d) < (part.radius - kMargin) * (part.radius - kMargin);
  };
  std::vector<double> area_up_to;
  double area = 0.0;
  for (const ThingPart& part : parts) {
    const glm::dvec3 e = part.to - part.from;
    area += part.radius == 0.0 ? 2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
                               : 2.0 * kPi * part.radius * (glm::length(e) + 2.0 * part.radius);
    area_up_to.push_back(area);
  }
  const glm::dmat3 turn = random_turn(random, true);
  SampledSurface surface;
  for (std::size_t i = 0; i < count; ++i) {
    const auto chosen =
        std::lower_bound(area_up_to.begin(), area_up_to.end(), area * random.uniform());
    const ThingPart& part = parts[std::min<std::size_t>(
        static_cast<std::size_t>(chosen - area_up_to.begin()), parts.size() - 1)];
    const glm::dvec3 e = part.to - part.from;
    Sample sample{part.from, glm::dvec3(0.0)};
    if (part.radius == 0.0) {
      const double faces = e.x * e.y + e.y * e.z + e.z * e.x, at = faces * random.uniform();
      const int axis = at < e.x * e.y ? 2 : at < e.x * e.y + e.y * e.z ? 0 : 1;
      const double x = random.uniform(), y = random.uniform(), z = random.uniform();
      sample.position += e * glm::dvec3(x, y, z);
      const bool far = random.uniform() < 0.5;
      sample.position[axis] = far ? part.to[axis] : part.from[axis];
      sample.normal[axis] = far ? 1.0 : -1.0;
    } else {
      // The height along a rod with round ends has an even distribution on its surface.
      const double length = glm::length(e), angle = 2.0 * kPi * random.uniform();
      const double height = (length + 2.0 * part.radius) * random.uniform() - part.radius;
      const glm::dvec3 axis = e / std::max(length, 1e-9);
      const double along = std::clamp(height, 0.0, length);
      const double up = (height - along) / part.radius;
      glm::dvec3 u, v;
      tangents(axis, u, v);
      sample.normal =
          std::sqrt(std::max(0.0, 1.0 - up * up)) * (cosine(angle) * u + sine(angle) * v) +
          up * axis;
      sample.position += along * axis + part.radius * sample.normal;
    }
    const bool hidden = std::any_of(parts.begin(), parts.end(), [&](const ThingPart& other) {
      return &other != &part && inside(other, sample.position);
    });
    if (!hidden) surface.push_back({turn * sample.position, turn * sample.normal});
  }
  return surface;
}

std::vector<ThingPart> furniture(Random& random) {
  std::vector<ThingPart> parts;
  const auto box = [&](const glm::dvec3& from, const glm::dvec3& size) {
    parts.push_back({from, from + size, 0.0});
  };
  const double width = 0.5 + 0.5 * random.uniform(), depth = 0.3 + 0.4 * random.uniform();
  const double leg = 0.02 + 0.03 * random.uniform(), board = 0.01 + 0.02 * random.uniform();
  const auto boards = 1 + random.below(4);
  const double height = 0.25 + 0.2 * random.uniform();
  for (const double x : {0.0, width - leg}) {
    for (const double z : {0.0, depth - leg}) box({x, 0, z}, {leg, height * boards, leg});
  }
  for (std::uint32_t b = 1; b <= boards; ++b) {
    box({0, height * b, 0}, {width, board, depth});
    for (auto things = random.below(4); things > 0; --things) {
      const double x = (width - 0.15) * random.uniform(), z = (depth - 0.15) * random.uniform();
      const double tall = 0.05 + 0.15 * random.uniform();
      const glm::dvec3 at(x, height * b + board, z);
      if (random.uniform() < 0.5) {
        box(at, {0.05 + 0.1 * random.uniform(), tall, 0.05 + 0.1 * random.uniform()});
      } else {
        parts.push_back({at + glm::dvec3(0.06, 0.03, 0.06), at + glm::dvec3(0.06, tall, 0.06),
                         0.02 + 0.03 * random.uniform()});
      }
    }
  }
  return parts;
}

std::vector<ThingPart> animal(Random& random) {
  std::vector<ThingPart> parts;
  const auto jitter = [&](double size) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return size * glm::dvec3(x, y, z);
  };
  const double length = 0.4 + 0.3 * random.uniform(), thick = 0.09 + 0.06 * random.uniform();
  const double legs = 0.15 + 0.3 * random.uniform();
  const glm::dvec3 back(0, legs, 0), front = back + glm::dvec3(length, 0, 0) + jitter(0.02);
  parts.push_back({back, front, thick});
  const glm::dvec3 head = front + glm::dvec3(0.12, 0.05 + 0.3 * random.uniform(), 0) + jitter(0.03);
  parts.push_back({front, head, 0.4 * thick});
  parts.push_back({head, head + glm::dvec3(0.1, -0.02, 0) + jitter(0.02), 0.5 * thick});
  for (const double side : {-0.6, 0.6}) {
    for (const glm::dvec3& hip : {back, front}) {
      const glm::dvec3 top = hip + glm::dvec3(0, -0.3 * thick, side * thick);
      const glm::dvec3 knee = top + glm::dvec3(0, -0.5 * legs, 0) + jitter(0.03);
      parts.push_back({top, knee, 0.3 * thick});
      parts.push_back({knee, glm::dvec3(knee.x, 0, knee.z) + jitter(0.01), 0.2 * thick});
    }
    parts.push_back({head, head + glm::dvec3(-0.02, 0.06, side * 0.06), 0.15 * thick});
  }
  parts.push_back({back, back + glm::dvec3(-0.2, 0.1, 0) + jitter(0.05), 0.15 * thick});
  return parts;
}

}  // namespace pointreel::bench
