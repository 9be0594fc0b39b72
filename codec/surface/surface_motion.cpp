#include "codec/surface/surface_motion.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace pointreel {
namespace {

constexpr std::size_t kLevels = 3;
constexpr int kMotionSteps = 4;
/// Edge of the grid of parts, in cells of pieces.
constexpr float kPartCells = 4.0f;
/// The cosine of the largest angle between pieces that match.
constexpr float kMatchCosine = 0.6f;
/// How far apart pieces that match may be, in cells.
constexpr float kReach = 1.5f;
/// The distance, in cells, at which a match counts half.
constexpr float kHalfWeight = 0.5f;
/// Pieces of more points are not more certain: what is left is how flat the surface is.
constexpr float kMostCounted = 20.0f;
/// The part of the evidence that stands for no motion in this step, so that parts do not slide
/// where nothing holds them.
constexpr double kDamping = 0.03;
/// A part that is at rest, or moves as the one above, stays so unless a step removes at least so
/// many times the mean square of the distances that are left. Noise of surfaces is alike over some
/// pieces, and a step has six unknowns.
constexpr double kSure = 40.0;
constexpr float kMostTurn = 0.5f;  ///< of one step, in radians
/// Where fewer of the pieces match, the surface is not there.
constexpr double kLeastMatched = 0.6;
/// By how much a single piece may be further away than those around it are on average.
constexpr float kMostOver = 2.5f;
/// A cell whose normals have a mean of less than this length is not flat.
constexpr float kLeastFlat = 0.3f;
constexpr float kFarCell = 1 << 20;

using Piece = SurfacePieces::Piece;

GridCell cell_of(const glm::vec3& position, float edge) { return GridCell::at(position / edge); }

/// `piece_of(i)`: a point, or a finer piece.
template <class PieceOf>
SurfacePieces pieces_of(std::size_t count, float cell, const PieceOf& piece_of) {
  SurfacePieces out;
  out.cell = cell;
  out.of_point.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Piece& added = piece_of(i);
    auto& slots = out.in_cell[cell_of(added.position, cell)];
    const bool opposite = slots[0] && glm::dot(out.pieces[*slots[0]].normal, added.normal) < 0.0f;
    std::optional<std::uint32_t>& slot = slots[opposite ? 1 : 0];
    if (!slot) {
      slot = static_cast<std::uint32_t>(out.pieces.size());
      out.pieces.emplace_back();
    }
    Piece& sum = out.pieces[*slot];
    sum.position += added.points * added.position;
    sum.normal += added.points * added.normal;
    sum.points += added.points;
    out.of_point[i] = *slot;
  }
  for (Piece& piece : out.pieces) {
    piece.position /= piece.points;
    const float length = glm::length(piece.normal);
    piece.normal = length > kLeastFlat * piece.points ? piece.normal / length : glm::vec3(0.0f);
  }
  return out;
}

/// Parts at the corners of a grid, each with a motion.
class Parts {
 public:
  struct Share {
    std::uint32_t part;
    float weight;
  };
  using Shares = std::array<Share, 8>;

  Parts() = default;
  /// Around all pieces. They begin with the motions of `coarser`.
  Parts(const SurfacePieces& pieces, const Parts& coarser, const glm::vec3& shift)
      : edge_(kPartCells * pieces.cell) {
    for (const Piece& piece : pieces.pieces) {
      const GridCell low = GridCell::at(piece.position / edge_ - 0.5f);
      for (int corner = 0; corner < 8; ++corner) {
        const GridCell cell = low.neighbor(corner);
        const auto [at, is_new] = at_.try_emplace(cell, static_cast<std::uint32_t>(motions.size()));
        if (!is_new) continue;
        const glm::vec3 center = (glm::vec3(cell.x, cell.y, cell.z) + 0.5f) * edge_;
        motions.push_back(coarser.motions.empty() ? RigidMotion{center, center + shift}
                                                  : coarser.motion(center));
      }
    }
  }

  float edge() const { return edge_; }

  /// The parts around a position, which blend there. `shares` holds them.
  std::span<const Share> around(const glm::vec3& position, Shares& shares) const {
    const glm::vec3 at = position / edge_ - 0.5f;
    const GridCell low = GridCell::at(at);
    const glm::vec3 f = glm::clamp(at - glm::vec3(low.x, low.y, low.z), 0.0f, 1.0f);
    std::size_t count = 0;
    float sum = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
      const float weight = ((corner & 1) != 0 ? f.x : 1.0f - f.x) *
                           ((corner & 2) != 0 ? f.y : 1.0f - f.y) *
                           ((corner & 4) != 0 ? f.z : 1.0f - f.z);
      const auto found = at_.find(low.neighbor(corner));
      if (weight < 1e-3f || found == at_.end()) continue;
      shares[count++] = {found->second, weight};
      sum += weight;
    }
    for (std::size_t i = 0; i < count; ++i) shares[i].weight /= sum;
    return std::span(shares).first(count);
  }

  /// Blended.
  RigidMotion motion(const glm::vec3& position) const {
    Shares memory;
    const std::span<const Share> shares = around(position, memory);
    RigidMotion out{position, position};
    if (shares.empty()) return out;
    out.to = glm::vec3(0.0f);
    glm::quat sum(0.0f, 0.0f, 0.0f, 0.0f);
    for (const auto& [part, weight] : shares) {
      const RigidMotion& one = motions[part];
      const bool flips = glm::dot(one.rotation, motions[shares[0].part].rotation) < 0.0f;
      out.to += weight * one(position);
      sum = sum + (flips ? -weight : weight) * one.rotation;
    }
    out.rotation = glm::normalize(sum);
    return out;
  }

  std::vector<RigidMotion> motions;

 private:
  float edge_ = 0.0f;
  std::unordered_map<GridCell, std::uint32_t, GridCell::Hash> at_;
};

struct Match {
  const Piece* piece = nullptr;  ///< null: there is none
  float distance = 0.0f;         ///< to its plane, signed
};

Match match(const SurfacePieces& pieces, const glm::vec3& position, const glm::vec3& normal) {
  const auto found = nearest_piece(pieces, position, normal, kMatchCosine, kReach * pieces.cell);
  if (!found) return {};
  const Piece& piece = pieces.pieces[*found];
  return {&piece, glm::dot(piece.position - position, piece.normal)};
}

/// The normal equations of one part's next step: a rotation vector, then a translation.
class PartStep {
 public:
  /// `share` of a piece belongs to the part.
  void add(const glm::vec3& arm, const glm::vec3& normal, float distance, float share, float sure) {
    const float weight = share * sure;
    const glm::vec3 turn = glm::cross(arm, normal);
    const std::array<double, 6> row{turn.x, turn.y, turn.z, normal.x, normal.y, normal.z};
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t c = 0; c <= r; ++c) matrix_[r][c] += weight * row[r] * row[c];
      right_[r] += weight * row[r] * distance;
    }
    weight_ += weight;
    squares_ += static_cast<double>(weight) * distance * distance;
    pieces_ += share;
  }

  /// `size`: the length at which a rotation counts as much as a translation.
  /// Returns whether the step is larger than noise explains.
  bool apply(RigidMotion& motion, double size, bool sure) const {
    if (!(weight_ > 0.0)) return false;
    const std::array<double, 6> x = solve(size);
    double gain = 0.0;
    for (std::size_t r = 0; r < 6; ++r) gain += x[r] * right_[r];
    if (!sure && gain * pieces_ < kSure * (squares_ - gain)) return false;
    const glm::vec3 turn(x[0], x[1], x[2]);
    const float angle = glm::length(turn);
    if (angle > 1e-9f)
      motion.rotation = glm::normalize(glm::angleAxis(std::min(angle, kMostTurn), turn / angle) *
                                       motion.rotation);
    motion.to += glm::vec3(x[3], x[4], x[5]);
    return true;
  }

 private:
  /// By Cholesky's factors of the damped matrix.
  std::array<double, 6> solve(double size) const {
    auto m = matrix_;
    std::array<double, 6> x = right_;
    for (std::size_t r = 0; r < 6; ++r) {
      m[r][r] += kDamping * weight_ * (r < 3 ? size * size : 1.0);
      for (std::size_t c = 0; c <= r; ++c) {
        for (std::size_t k = 0; k < c; ++k) m[r][c] -= m[r][k] * m[c][k];
        if (c < r) {
          m[r][c] /= m[c][c];
        } else {
          m[r][r] = std::sqrt(m[r][r]);
        }
      }
    }
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t k = 0; k < r; ++k) x[r] -= m[r][k] * x[k];
      x[r] /= m[r][r];
    }
    for (std::size_t r = 6; r-- > 0;) {
      for (std::size_t k = r + 1; k < 6; ++k) x[r] -= m[k][r] * x[k];
      x[r] /= m[r][r];
    }
    return x;
  }

  std::array<std::array<double, 6>, 6> matrix_{};  ///< its lower half
  std::array<double, 6> right_{};
  double weight_ = 0.0, squares_ = 0.0, pieces_ = 0.0;
};

/// Pieces where the parts move them.
struct Moved {
  std::vector<Parts::Shares> memory;
  std::vector<std::span<const Parts::Share>> shares;

  Moved(const SurfacePieces& pieces, const Parts& parts)
      : memory(pieces.pieces.size()), shares(pieces.pieces.size()) {
    for (std::size_t i = 0; i < memory.size(); ++i)
      shares[i] = parts.around(pieces.pieces[i].position, memory[i]);
  }

  Piece at(std::size_t i, const Piece& piece, const Parts& parts) const {
    Piece out{glm::vec3(0.0f), glm::vec3(0.0f), piece.points};
    for (const auto& [part, weight] : shares[i]) {
      const RigidMotion& motion = parts.motions[part];
      out.position += weight * motion(piece.position);
      out.normal += weight * (motion.rotation * piece.normal);
    }
    const float length = glm::length(out.normal);
    if (length > 0.0f) out.normal /= length;
    return out;
  }
};

/// `moving`: the parts that differ from those of the level above.
void take_step(const SurfacePieces& from, const SurfacePieces& to, const Moved& moved, Parts& parts,
               std::vector<bool>& moving) {
  std::vector<PartStep> steps(parts.motions.size());
  for (std::size_t i = 0; i < from.pieces.size(); ++i) {
    const Piece piece = moved.at(i, from.pieces[i], parts);
    const Match found = match(to, piece.position, piece.normal);
    if (found.piece == nullptr) continue;
    const float far = found.distance / (kHalfWeight * from.cell);
    const float sure =
        std::min({piece.points, found.piece->points, kMostCounted}) / (1.0f + far * far);
    for (const auto& [part, weight] : moved.shares[i])
      steps[part].add(piece.position - parts.motions[part].to, found.piece->normal, found.distance,
                      weight, sure);
  }
  for (std::size_t part = 0; part < steps.size(); ++part)
    moving[part] = steps[part].apply(parts.motions[part], 0.5 * parts.edge(), moving[part]);
}

/// What a part's pieces say about how well it fits.
struct Fit {
  double pieces = 0.0, matched = 0.0, squares = 0.0;

  void add(const Fit& other, double share) {
    pieces += share * other.pieces;
    matched += share * other.matched;
    squares += share * other.squares;
  }
  bool is_good(float tolerance) const {
    return matched >= kLeastMatched * pieces &&
           squares <= static_cast<double>(tolerance) * tolerance * matched;
  }
};

std::vector<bool> find_continued(const SurfacePieces& from, const SurfacePieces& to,
                                 const Parts& parts, float tolerance) {
  const Moved moved(from, parts);
  std::vector<Match> matches(from.pieces.size());
  std::vector<Fit> fits(parts.motions.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Piece piece = moved.at(i, from.pieces[i], parts);
    matches[i] = match(to, piece.position, piece.normal);
    const bool there = matches[i].piece != nullptr;
    const Fit one{1.0, there ? 1.0 : 0.0, there ? matches[i].distance * matches[i].distance : 0.0};
    for (const auto& [part, weight] : moved.shares[i]) fits[part].add(one, weight);
  }
  std::vector<bool> continued(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches[i].piece == nullptr || std::abs(matches[i].distance) > kMostOver * tolerance)
      continue;
    Fit around;
    for (const auto& [part, weight] : moved.shares[i]) around.add(fits[part], weight);
    continued[i] = around.is_good(tolerance);
  }
  return continued;
}

}  // namespace

GridCell GridCell::at(const glm::vec3& in_cells) {
  // NaN, which unbounded motions give, counts as far away.
  const auto cell = [](float at) {
    const float low = std::floor(at);
    return static_cast<std::int32_t>(low > -kFarCell ? std::min(low, kFarCell) : -kFarCell);
  };
  return {cell(in_cells.x), cell(in_cells.y), cell(in_cells.z)};
}

GridCell GridCell::neighbor(int corner) const {
  return {x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)};
}

std::size_t GridCell::Hash::operator()(const GridCell& cell) const {
  std::uint64_t hash = 0;
  for (const std::int32_t part : {cell.x, cell.y, cell.z}) {
    hash = (hash ^ static_cast<std::uint32_t>(part)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

std::optional<std::uint32_t> nearest_piece(const SurfacePieces& pieces, const glm::vec3& position,
                                           const glm::vec3& normal, float least_cosine,
                                           float reach) {
  std::optional<std::uint32_t> nearest;
  float least = reach * reach;
  const GridCell low = GridCell::at(position / pieces.cell - 0.5f);
  for (int corner = 0; corner < 8; ++corner) {
    const auto found = pieces.in_cell.find(low.neighbor(corner));
    if (found == pieces.in_cell.end()) continue;
    for (const std::optional<std::uint32_t>& slot : found->second) {
      if (!slot || glm::dot(pieces.pieces[*slot].normal, normal) < least_cosine) continue;
      const glm::vec3 way = pieces.pieces[*slot].position - position;
      const float square = glm::dot(way, way);
      if (square >= least) continue;
      least = square;
      nearest = slot;
    }
  }
  return nearest;
}

SurfacePyramid surface_pyramid(const PointCloud& cloud, float cell) {
  SurfacePyramid pyramid{cloud.origin, {}};
  pyramid.levels.push_back(pieces_of(cloud.size(), cell, [&](std::size_t i) {
    return Piece{cloud.positions[i], cloud.normals[i], 1.0f};
  }));
  while (pyramid.levels.size() < kLevels) {
    const SurfacePieces& finer = pyramid.levels.back();
    pyramid.levels.push_back(pieces_of(finer.pieces.size(), 2.0f * finer.cell,
                                       [&](std::size_t i) { return finer.pieces[i]; }));
  }
  return pyramid;
}

std::vector<std::optional<RigidMotion>> surface_motion(const SurfacePyramid& from,
                                                       const std::vector<glm::vec3>& positions,
                                                       const SurfacePyramid& to, float tolerance) {
  Parts parts;
  const glm::vec3 shift(from.origin - to.origin);
  for (std::size_t level = kLevels; level-- > 0;) {
    const SurfacePieces &pieces = from.levels[level], &others = to.levels[level];
    parts = Parts(pieces, parts, shift);
    const Moved moved(pieces, parts);
    std::vector<bool> moving(parts.motions.size());
    for (int step = 0; step < kMotionSteps; ++step) take_step(pieces, others, moved, parts, moving);
  }
  const SurfacePieces& finest = from.levels.front();
  const std::vector<bool> continued = find_continued(finest, to.levels.front(), parts, tolerance);
  std::vector<std::optional<RigidMotion>> motions(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (continued[finest.of_point[i]]) motions[i] = parts.motion(positions[i]);
  return motions;
}

}  // namespace pointreel
