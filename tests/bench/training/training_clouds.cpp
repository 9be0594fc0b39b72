#include "tests/bench/training/training_clouds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "common/base/try.h"
#include "common/octree/build.h"
#include "common/surface/clean.h"
#include "datasets_synthetic/body.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/sequences.h"
#include "datasets_synthetic/trigonometry.h"
#include "pointreel/octree.h"
#include "tests/bench/training/relief.h"

namespace pointreel::bench {
namespace {

/// A point of a surface and its normal, in units of about the largest extent of the surface.
struct Sample {
  glm::dvec3 position, normal;
};
using SampledSurface = std::vector<Sample>;

// --- Surfaces ---

glm::dmat3 random_turn(Random& random, bool upright) {
  const double a = 2.0 * kPi * random.uniform();
  const glm::dmat3 about_y(cosine(a), 0, -sine(a), 0, 1, 0, sine(a), 0, cosine(a));
  if (upright) return about_y;
  const double b = 2.0 * kPi * random.uniform(), c = 2.0 * kPi * random.uniform();
  const glm::dmat3 about_x(1, 0, 0, 0, cosine(b), sine(b), 0, -sine(b), cosine(b));
  const glm::dmat3 about_z(cosine(c), sine(c), 0, -sine(c), cosine(c), 0, 0, 0, 1);
  return about_z * about_x * about_y;
}

/// A figure of the synthetic sequences in a random pose. Its samples are in random order.
Result<SampledSurface> figure(std::size_t count, Random& random) {
  const std::span<const Motion> all = motions();
  const Motion& motion = all[random.below(static_cast<std::uint32_t>(all.size()))];
  const Body body = pose_body(motion.pose(motion.seconds() * random.uniform()));
  const auto points = TRY(sample_uniform(body.surface, count, random.bits()));
  const glm::dmat3 turn = random_turn(random, true);
  SampledSurface surface;
  surface.reserve(points.size());
  for (const SurfacePoint& point : points) {
    surface.push_back({turn * point.position / 1.76, turn * point.normal});
  }
  return surface;
}

/// Ground as an aircraft sees it, with one height at each place.
SampledSurface terrain(std::size_t count, Random& random) {
  const Relief relief = Relief::fractal(0.7, 0.001, 0.08, 1.0, 0.3, random);
  SampledSurface surface(count);
  for (Sample& sample : surface) {
    const double x = random.uniform(), y = random.uniform();
    sample = {{x, y, relief.height({x, y, 0.5})}, {0, 0, 1}};
  }
  return surface;
}

/// Two unit vectors perpendicular to the normal n and to each other (Duff et al., JCGT 6(1), 2017).
void tangents(const glm::dvec3& n, glm::dvec3& u, glm::dvec3& v) {
  const double sign = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  u = {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  v = {b, sign + n.y * n.y * a, -n.y};
}

/// A figure with few flat faces, like a low-poly model: prisms along the bones of a body.
SampledSurface faceted_figure(std::size_t count, Random& random) {
  const auto jitter = [&](double size) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return size * glm::dvec3(x, y, z);
  };
  struct Bone {
    glm::dvec3 from, to;
    double radius;
  };
  const glm::dvec3 hip(0.0, 0.52, 0.0), neck(0.0, 0.83, 0.0);
  std::vector<Bone> bones = {{hip, neck, 0.09}, {neck, neck + glm::dvec3(0, 0.15, 0), 0.06}};
  for (const double side : {-1.0, 1.0}) {
    const glm::dvec3 elbow = glm::dvec3(side * 0.25, 0.66, 0) + jitter(0.05);
    const glm::dvec3 hand = elbow + glm::dvec3(side * 0.06, -0.15, 0.05) + jitter(0.05);
    const glm::dvec3 knee = glm::dvec3(side * 0.1, 0.27, 0.02) + jitter(0.03);
    const glm::dvec3 foot = knee + glm::dvec3(0, -0.25, -0.02) + jitter(0.03);
    bones.insert(bones.end(), {{neck + glm::dvec3(side * 0.1, -0.03, 0), elbow, 0.04},
                               {elbow, hand, 0.03},
                               {hip + glm::dvec3(side * 0.06, 0, 0), knee, 0.06},
                               {knee, foot, 0.045},
                               {foot, foot + glm::dvec3(0, -0.02, 0.12), 0.035}});
  }
  std::vector<std::array<glm::dvec3, 3>> faces;
  std::vector<double> area_up_to;
  double area = 0.0;
  const auto add = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
    faces.push_back({a, b, c});
    area_up_to.push_back(area);
  };
  for (const Bone& bone : bones) {
    const auto sides = 5 + random.below(4);
    glm::dvec3 u, v;
    const glm::dvec3 axis = bone.to - bone.from;
    tangents(glm::normalize(axis), u, v);
    constexpr int kRings = 4;
    std::vector<glm::dvec3> ring, last;
    for (int r = 0; r <= kRings; ++r, last = std::move(ring), ring.clear()) {
      const double radius =
          bone.radius * (r == 0 || r == kRings ? 0.5 : 0.8 + 0.4 * random.uniform());
      const glm::dvec3 center = bone.from + axis * (double(r) / kRings);
      for (std::uint32_t s = 0; s < sides; ++s) {
        const double angle = 2.0 * kPi * s / sides;
        ring.push_back(center + radius * (cosine(angle) * u + sine(angle) * v) + jitter(0.003));
      }
      for (std::uint32_t s = 0; s < sides; ++s) {
        const std::uint32_t next = (s + 1) % sides;
        if (r == 0 || r == kRings) add(center, ring[s], ring[next]);
        if (r == 0) continue;
        add(last[s], last[next], ring[s]);
        add(ring[s], last[next], ring[next]);
      }
    }
  }
  const glm::dmat3 turn = random_turn(random, true);
  SampledSurface surface;
  for (std::size_t i = 0; i < count; ++i) {
    const auto face =
        std::lower_bound(area_up_to.begin(), area_up_to.end(), area * random.uniform());
    const auto& [p, q, r] = faces[std::min<std::size_t>(
        static_cast<std::size_t>(face - area_up_to.begin()), faces.size() - 1)];
    double s = random.uniform(), t = random.uniform();
    if (s + t > 1.0) {
      s = 1.0 - s;
      t = 1.0 - t;
    }
    const glm::dvec3 normal = glm::cross(q - p, r - p);
    surface.push_back({turn * (p + s * (q - p) + t * (r - p)),
                       turn * (normal / std::max(glm::length(normal), 1e-12))});
  }
  return surface;
}

/// Part of a thing: a box, or a rod with round ends.
struct ThingPart {
  glm::dvec3 from, to;  ///< the corners of the box, or the ends of the rod
  double radius;        ///< 0: a box
};

/// Points on the parts of a thing that are not inside of others. Points on a part are evenly
/// spread; each part has as many as its share of the surface.
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

/// A table or shelf, with things on it.
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

/// A body on four legs, with a neck, a head and a tail.
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

/// The surface with every point moved along its normal.
SampledSurface displaced(const SampledSurface& surface, const Relief& relief) {
  SampledSurface out(surface.size());
  tbb::parallel_for(std::size_t{0}, surface.size(), [&](std::size_t i) {
    const Sample& sample = surface[i];
    out[i] = {sample.position + relief.height(sample.position) * sample.normal, sample.normal};
  });
  return out;
}

// --- Samplers ---

/// Replaces each sample by five, which lie a little apart on the surface, so that no voxel on it
/// stays empty.
SampledSurface filled(const SampledSurface& surface, double spacing) {
  SampledSurface out;
  out.reserve(5 * surface.size());
  for (const Sample& sample : surface) {
    glm::dvec3 u, v;
    tangents(sample.normal, u, v);
    out.push_back(sample);
    for (const glm::dvec3& d : {u, -u, v, -v}) {
      out.push_back({sample.position + spacing * d, sample.normal});
    }
  }
  return out;
}

SampledSurface first(const SampledSurface& surface, std::size_t count) {
  return {surface.begin(),
          surface.begin() + static_cast<std::ptrdiff_t>(std::min(count, surface.size()))};
}

/// Keeps samples like the vertices of a scanned mesh: no two are closer than a distance that varies
/// slowly over the surface (dart throwing: Cook, "Stochastic sampling in computer graphics", 1986).
SampledSurface spaced(const SampledSurface& surface, double distance, double variation,
                      Random& random) {
  constexpr std::size_t kBuckets = 1u << 20;
  const std::uint64_t seed = random.bits();
  const double cell = distance * (1.0 + variation);
  std::vector<std::uint32_t> head(kBuckets, ~0u), next;
  SampledSurface out;
  const auto bucket = [](const glm::ivec3& c) {
    return (static_cast<std::uint32_t>(c.x) * 73856093u ^
            static_cast<std::uint32_t>(c.y) * 19349663u ^
            static_cast<std::uint32_t>(c.z) * 83492791u) %
           kBuckets;
  };
  for (const Sample& sample : surface) {
    const glm::ivec3 at(glm::floor(sample.position / cell));
    const double here = distance * (1.0 + variation * lattice_noise(sample.position * 12.0, seed));
    bool apart = true;
    for (int i = 0; i < 27 && apart; ++i) {
      const glm::ivec3 around = at + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      for (std::uint32_t other = head[bucket(around)]; other != ~0u && apart; other = next[other]) {
        const glm::dvec3 d = out[other].position - sample.position;
        apart = glm::dot(d, d) >= here * here;
      }
    }
    if (!apart) continue;
    next.push_back(head[bucket(at)]);
    head[bucket(at)] = static_cast<std::uint32_t>(out.size());
    out.push_back(sample);
  }
  return out;
}

/// The errors of depth cameras: each camera is shifted and distorted, measures depth in steps, and
/// places "flying" points between near and far objects at their edges.
struct CameraErrors {
  double shift = 0.0, bend = 0.0, step = 0.0, flying = 0.0;
};

/// The points that cameras around the surface see: the nearest one in each of their pixels.
SampledSurface scanned(const SampledSurface& surface, int cameras, double pixel, Random& random,
                       const CameraErrors& errors = {}) {
  SampledSurface out;
  const double begin = random.uniform();
  for (int camera = 0; camera < cameras; ++camera) {
    const double a = 2.0 * kPi * (begin + (camera + 0.3 * random.uniform()) / cameras);
    const glm::dvec3 to_camera =
        glm::normalize(glm::dvec3(cosine(a), 0.6 * (random.uniform() - 0.4), sine(a)));
    glm::dvec3 u, v;
    tangents(to_camera, u, v);
    constexpr int kSide = 1 << 11;
    std::vector<std::uint32_t> nearest(std::size_t{kSide} * kSide, ~0u);
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      if (glm::dot(surface[i].normal, to_camera) < 0.15) continue;
      const auto x = static_cast<int>(std::floor(glm::dot(surface[i].position, u) / pixel));
      const auto y = static_cast<int>(std::floor(glm::dot(surface[i].position, v) / pixel));
      std::uint32_t& best =
          nearest[static_cast<std::size_t>((x & (kSide - 1)) * kSide + (y & (kSide - 1)))];
      if (best == ~0u ||
          glm::dot(surface[i].position, to_camera) > glm::dot(surface[best].position, to_camera)) {
        best = i;
      }
    }
    if (errors.shift == 0.0) {
      for (const std::uint32_t i : nearest) {
        if (i != ~0u) out.push_back({surface[i].position, to_camera});
      }
      continue;
    }
    const double x = random.normal(), y = random.normal(), z = random.normal();
    const glm::dvec3 shift = errors.shift * glm::dvec3(x, y, z);
    const std::uint64_t bend_seed = random.bits();
    for (std::size_t at = 0; at < nearest.size(); ++at) {
      const std::uint32_t i = nearest[at];
      if (i == ~0u) continue;
      glm::dvec3 position = surface[i].position;
      double depth = glm::dot(position, to_camera);
      const std::uint32_t beside = nearest[(at + 1) % nearest.size()];
      const double gap =
          beside == ~0u ? 0.1 : depth - glm::dot(surface[beside].position, to_camera);
      const double before = depth;
      if (gap > 0.01 && random.uniform() < errors.flying) depth -= gap * random.uniform();
      if (errors.step > 0.0) depth = errors.step * std::floor(depth / errors.step + 0.5);
      depth += errors.bend * lattice_noise(position * 6.0, bend_seed);
      position += (depth - before) * to_camera + shift;
      out.push_back({position, to_camera});
    }
  }
  return out;
}

/// Adds errors along the normal (for scanned surfaces: along the line of sight), occasionally
/// larger ones, and outliers.
void disturb(SampledSurface& surface, double noise, double outliers, Random& random) {
  for (Sample& sample : surface) {
    const double scale = random.uniform() < 0.1 ? 3.0 * noise : noise;
    sample.position += scale * random.normal() * sample.normal;
    if (random.uniform() >= outliers) continue;
    const double x = random.normal(), y = random.normal(), z = random.normal();
    sample.position += 0.02 * glm::dvec3(x, y, z);
  }
}

/// Arranges points in lines like those of an airborne scanner: close within a line and further
/// apart from line to line, with some returns from vegetation above the ground.
SampledSurface flown_over(const SampledSurface& ground, double line, double vegetation,
                          Random& random) {
  const std::uint64_t seed = random.bits();
  SampledSurface out;
  for (Sample sample : ground) {
    const double lines = sample.position.x / line;
    const double spread = 0.25 * random.uniform();
    sample.position.x = line * (std::floor(lines) + spread * random.normal());
    const double wood = lattice_noise(sample.position * 9.0, seed) - 0.1;
    if (wood > 0.0 && random.uniform() < vegetation) {
      const double top = 0.01 + 0.03 * wood;
      sample.position.z += top * random.uniform();
    }
    out.push_back(sample);
  }
  return out;
}

/// Puts flat roofs and walls on a tenth of the ground and rotates everything, because no flight
/// follows the grid.
SampledSurface built_up(SampledSurface ground, Random& random) {
  const std::uint64_t seed = random.bits();
  for (Sample& sample : ground) {
    const glm::dvec3 block = glm::floor(sample.position * 14.0);
    const double kind = lattice_noise({block.x, block.y, 0.5}, seed);
    const glm::dvec3 in = sample.position * 14.0 - block;
    if (kind < 0.25 || in.x < 0.2 || in.x > 0.7 || in.y < 0.3 || in.y > 0.8) continue;
    const double height = 0.008 + 0.02 * kind;
    const bool wall = in.x > 0.68 && random.uniform() < 0.4;
    sample.position.z = 0.05 + (wall ? height * random.uniform() : height);
  }
  const double a = 2.0 * kPi * random.uniform();
  for (Sample& sample : ground) {
    const glm::dvec3 p = sample.position;
    sample.position = {cosine(a) * p.x - sine(a) * p.y, sine(a) * p.x + cosine(a) * p.y, p.z};
  }
  return ground;
}

/// The points of a cloud whose normals are not needed.
SampledSurface surface_of(const PointCloud& cloud) {
  SampledSurface surface;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    surface.push_back({cloud.world(i) / 1.76, {0, 0, 1}});
  }
  return surface;
}

/// A random frame of a synthetic sequence from one of its own samplers.
Result<SampledSurface> sequence_sample(const Motion& motion, const SequenceOptions& options,
                                       Random& random) {
  const int frames = static_cast<int>(motion.seconds() * options.fps);
  return surface_of(TRY(sequence_frame(
      motion, options, static_cast<int>(random.below(static_cast<std::uint32_t>(frames))))));
}

// --- Voxels ---

/// The tree of the occupied cells of a grid with 2^bits cells along the largest extent of the
/// surface. A `margin` above 0 leaves that share of the grid empty.
Svo tree_of(const SampledSurface& surface, int bits, double margin = 0.0) {
  glm::dvec3 low(1e30), high(-1e30);
  for (const Sample& sample : surface) {
    low = glm::min(low, sample.position);
    high = glm::max(high, sample.position);
  }
  const glm::dvec3 extent = high - low;
  const double edge = std::max({extent.x, extent.y, extent.z, 1e-9});
  const double cells = std::ldexp(1.0, bits), scale = (cells - 1.0) * (1.0 - margin) / edge;
  PointCloud cloud;
  cloud.positions.reserve(surface.size());
  for (const Sample& sample : surface) {
    cloud.positions.emplace_back(glm::floor((sample.position - low) * scale + 0.5) + 0.5);
  }
  return build_svo(sort_points(cloud, Cube{glm::dvec3(0.0), cells}, bits), bits);
}

constexpr std::size_t kSamples = 1'200'000;

/// Makes the trees of surfaces and passes them on to the training.
class Giver {
 public:
  using Use = std::function<void(const std::string& name, const Svo& svo)>;
  explicit Giver(const Use& use) : use_(use) {}

  void operator()(const std::string& name, const Svo& svo) const { use_(name, svo); }

  /// Passes on tree_of(surface, bits, margin).
  void operator()(const std::string& name, const SampledSurface& surface, int bits,
                  double margin = 0.0) const {
    use_(name, tree_of(surface, bits, margin));
  }

 private:
  const Use& use_;
};

/// Figures that are sampled densely, at random, with the spacing of vertices, and by cameras.
Result<void> give_figures(std::uint64_t seed, const Giver& give) {
  constexpr int kFigures = 6;
  for (int f = 0; f < kFigures; ++f) {
    Random random(seed, static_cast<std::uint64_t>(f));
    const SampledSurface smooth = TRY(figure(kSamples, random));
    const auto name = [f](const char* what) { return fmt::format("figure {} {}", f, what); };
    const double roughness = 0.2 + 1.2 * random.uniform();
    const SampledSurface rough =
        displaced(smooth, Relief::fractal(0.12, 0.001, 0.006 * roughness, 1.0, 0.4, random));
    const SampledSurface fine =
        displaced(rough, Relief::fractal(0.01, 0.0005, 0.0012 * roughness, 0.5, 0.0, random));

    const SampledSurface& dense = f % 2 == 0 ? rough : fine;
    give(name("dense 10"), filled(dense, 0.4 / 1024), 10, 0.05 * random.uniform());
    if (f % 3 == 0) give(name("dense 9"), dense, 9, 0.3 * random.uniform());
    if (f % 2 == 1) give(name("smooth 10"), filled(smooth, 0.4 / 1024), 10, 0.02 * f);
    if (f % 2 == 0) give(name("dense 10 again"), filled(fine, 0.4 / 1024), 10, 0.01 * f);

    give(name("random 90,000 10"), first(f % 2 == 0 ? smooth : rough, 90'000), 10,
         0.1 * random.uniform());
    if (f % 3 == 1) give(name("random 250,000 12"), first(rough, 250'000), 12);
    if (f % 3 == 2) give(name("random 60,000 9"), first(rough, 60'000), 9);

    const SampledSurface vertices = spaced(fine, 0.0014 + 0.0002 * f, 0.15 + 0.05 * f, random);
    give(name("spaced 10"), vertices, 10);
    give(name("spaced 12"), vertices, 12);
    if (f % 2 == 0) give(name("spaced 11"), spaced(rough, 0.004, 0.3, random), 11);

    SampledSurface seen = scanned(rough, 5, (1.8 + 3.0 * random.uniform()) / 1024, random);
    disturb(seen, (0.3 + random.uniform()) / 1024, 0.004, random);
    give(name("scanned 10"), seen, 10);
    if (f % 3 == 0) {
      SampledSurface noisy = first(rough, 400'000);
      disturb(noisy, (0.4 + random.uniform()) / 1024, 0.001, random);
      give(name("noisy 10"), noisy, 10);
    }
  }
  return {};
}

/// Figures with few faces, sampled at random.
void give_faceted(std::uint64_t seed, const Giver& give) {
  for (int f = 0; f < 4; ++f) {
    Random random(seed, 3000 + static_cast<std::uint64_t>(f));
    give(fmt::format("faceted {} 10", f),
         faceted_figure(60'000 + 15'000 * static_cast<std::size_t>(f), random), 10,
         0.1 * random.uniform());
  }
}

/// Figures as several badly calibrated cameras see them, noisy and sparse.
Result<void> give_captures(std::uint64_t seed, const Giver& give) {
  for (int f = 0; f < 4; ++f) {
    Random random(seed, 4000 + static_cast<std::uint64_t>(f));
    const SampledSurface smooth = TRY(figure(kSamples, random));
    const SampledSurface rough =
        displaced(smooth, Relief::fractal(0.1, 0.001, 0.004, 1.0, 0.4, random));
    const double voxel = 1.0 / 1024;
    CameraErrors errors;
    errors.shift = voxel * (0.5 + random.uniform());
    errors.bend = voxel * 2.0 * random.uniform();
    errors.step = f % 2 == 0 ? 0.0 : voxel * (0.5 + 1.5 * random.uniform());
    errors.flying = 0.1 + 0.3 * random.uniform();
    SampledSurface seen =
        scanned(rough, 4 + 2 * f, voxel * (2.0 + 0.8 * f + random.uniform()), random, errors);
    disturb(seen, voxel * (0.3 + 0.9 * random.uniform()), 0.003, random);
    give(fmt::format("captured {} 10", f), seen, 10);
  }
  return {};
}

/// The voxels that the figures of the synthetic sequences pass through. The kick is left out, so
/// that it can be measured.
Result<void> give_voxels(const Giver& give) {
  for (const char* name : {"baseball", "basketball", "soccer-juggle", "soccer-shoot"}) {
    const Motion& motion = *find_motion(name);
    SequenceOptions options;
    for (const int bits : {8, 9, 10}) {
      options.voxels = voxel_grid(sequence_bounds(motion, options.fps, motion.poses), bits);
      const int pose = motion.poses * (2 * bits - 15) / 6;
      const PointCloud cloud = TRY(sequence_frame(motion, options, pose));
      const VoxelCube cube = voxel_cube(bounds(cloud), 1.0);
      give(fmt::format("voxels {} {}", name, bits),
           build_svo(sort_points(cloud, cube.cube, cube.depth), cube.depth));
    }
  }
  return {};
}

/// The synthetic sequences with their own samplers: the curves of a scanner, and parallel rays.
Result<void> give_sequences(std::uint64_t seed, const Giver& give) {
  for (int m = 0; m < 6; ++m) {
    Random random(seed, 5000 + static_cast<std::uint64_t>(m));
    const std::span<const Motion> all = motions();
    const Motion& motion = all[static_cast<std::size_t>(m) % all.size()];
    SequenceOptions options;
    options.seed = random.bits();
    options.noise = m < 3 ? 0.0015 * m : 0.0;
    if (m >= 3) options.points = 30'000u << (m - 3);
    const auto curves = TRY(sequence_sample(motion, options, random));
    give(fmt::format("curves {} {}", m, m < 5 ? 10 : 11), curves, m < 5 ? 10 : 11,
         0.1 * random.uniform());
    if (m >= 2) continue;
    options.noise = 0.0;
    options.sampler = Sampler::ldc;
    const auto layered = TRY(sequence_sample(motion, options, random));
    give(fmt::format("layered {} 10", m), layered, 10, 0.1 * random.uniform());
  }
  return {};
}

/// What the sequences' ring of depth cameras measures, as it comes and cleaned, in the cells that
/// each of them would be coded in, and in larger ones.
Result<void> give_depth_cameras(std::uint64_t seed, const Giver& give) {
  constexpr std::array<std::size_t, 5> kPoints = {12'000, 25'000, 50'000, 90'000, 150'000};
  for (std::size_t c = 0; c < kPoints.size(); ++c) {
    Random random(seed, 7000 + c);
    const std::span<const Motion> all = motions();
    const Motion& motion = all[(c + 2) % all.size()];
    SequenceOptions options;
    options.seed = random.bits();
    options.sampler = Sampler::depth_cameras;
    options.points = kPoints[c];
    const int frames = static_cast<int>(motion.seconds() * options.fps);
    PointCloud cloud = TRY(sequence_frame(
        motion, options, static_cast<int>(random.below(static_cast<std::uint32_t>(frames)))));
    for (const bool cleaned : {false, true}) {
      if (cleaned) clean(cloud);
      const SampledSurface surface = surface_of(cloud);
      const int bits = c == 0 ? 8 : c < 3 ? 9 : 10;
      for (const int more : {0, 1}) {
        give(fmt::format("depth cameras {} {}{}", c, bits + more, cleaned ? " cleaned" : ""),
             surface, bits + more, 0.1 * random.uniform());
      }
    }
  }
  return {};
}

/// Towns and hills as an airborne scanner sees them.
void give_terrain(std::uint64_t seed, const Giver& give) {
  for (int t = 0; t < 2; ++t) {
    Random random(seed, 6000 + static_cast<std::uint64_t>(t));
    const SampledSurface ground = terrain(450'000, random);
    const double line = 0.0006 + 0.0012 * random.uniform();
    const SampledSurface flown =
        built_up(flown_over(ground, line, 0.2 + 0.4 * random.uniform(), random), random);
    give(fmt::format("town {} 12", t), flown, 12);
  }
  for (int t = 0; t < 3; ++t) {
    Random random(seed, 1000 + static_cast<std::uint64_t>(t));
    const SampledSurface ground = terrain(400'000, random);
    const SampledSurface flown =
        flown_over(ground, 0.0008 + 0.0015 * random.uniform(), 0.3, random);
    give(fmt::format("terrain {} 12", t), flown, 12);
    if (t == 0) give(fmt::format("terrain {} 10", t), ground, 10);
  }
}

/// Furniture and animals, sampled densely, at random, with the spacing of vertices, and by cameras.
void give_things(std::uint64_t seed, const Giver& give) {
  for (int t = 0; t < 6; ++t) {
    Random random(seed, 8000 + static_cast<std::uint64_t>(t));
    const bool alive = t % 2 == 1;
    const SampledSurface smooth =
        sample_thing(alive ? animal(random) : furniture(random), kSamples, random);
    const double roughness = alive ? 0.3 + random.uniform() : 0.1 * random.uniform();
    const SampledSurface rough =
        displaced(smooth, Relief::fractal(0.08, 0.0008, 0.005 * roughness, 0.8, 0.2, random));
    const auto name = [&](const char* what) {
      return fmt::format("{} {} {}", alive ? "animal" : "furniture", t, what);
    };
    if (t < 4) give(name("dense 10"), filled(rough, 0.4 / 1024), 10, 0.1 * random.uniform());
    give(name("random 10"), first(rough, 30'000u << (t / 2)), 10, 0.1 * random.uniform());
    give(name("spaced 10"), spaced(rough, 0.002 + 0.001 * t, 0.3, random), 10);
    SampledSurface seen = scanned(rough, 5, (1.8 + 3.0 * random.uniform()) / 1024, random);
    disturb(seen, (0.2 + random.uniform()) / 1024, 0.003, random);
    give(name("scanned 10"), seen, 10);
    if (t < 2) give(name("scanned 12"), seen, 12);
  }
}

/// Points that fill a volume.
void give_volume(std::uint64_t seed, const Giver& give) {
  Random random(seed, 2000);
  SampledSurface cloudy(40'000);
  for (Sample& sample : cloudy) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    sample = {{x, y, z}, {0, 0, 1}};
  }
  give("volume 8", cloudy, 8);
}

}  // namespace

Result<void> for_each_training_tree(
    std::uint64_t seed, const std::function<void(const std::string& name, const Svo& svo)>& use) {
  const Giver give(use);
  TRY(give_figures(seed, give));
  give_faceted(seed, give);
  TRY(give_captures(seed, give));
  TRY(give_sequences(seed, give));
  TRY(give_voxels(give));
  TRY(give_depth_cameras(seed, give));
  give_terrain(seed, give);
  give_things(seed, give);
  give_volume(seed, give);
  return {};
}

}  // namespace pointreel::bench
