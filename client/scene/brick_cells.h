#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

// A brick is a node two levels above the leaves, and its 4^3 cells are the bits of one number. So
// what lies beside each of the cells is found for all 64 at once.

namespace pointreel {

/// Cells of a brick: bit x + 4 y + 16 z.
using Cells = std::uint64_t;

constexpr unsigned cell_number(int x, int y, int z) {
  return static_cast<unsigned>(x + 4 * y + 16 * z);
}

/// All cells of a node's first child. Those of the next child are two further along an axis.
constexpr Cells kChild = 0x330033;
constexpr unsigned child_shift(unsigned child) {
  return cell_number(2 * static_cast<int>(child & 1u), 2 * static_cast<int>(child >> 1 & 1u),
                     2 * static_cast<int>(child >> 2));
}

/// The cells of that child that its mask names, and the mask from the cells.
constexpr auto kSpread = [] {
  std::array<Cells, 256> spread{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (int c = 0; c < 8; ++c) {
      if (mask >> c & 1u) spread[mask] |= Cells{1} << cell_number(c & 1, c >> 1 & 1, c >> 2);
    }
  }
  return spread;
}();
constexpr unsigned mask_of(Cells cells) {
  return static_cast<unsigned>((cells & 3u) | (cells >> 4 & 3u) << 2 | (cells >> 16 & 3u) << 4 |
                               (cells >> 20 & 3u) << 6);
}

/// The position of each cell in the order of the leaves, and the cells in that order.
constexpr auto kOrder = [] {
  std::array<std::uint8_t, 64> order{};
  for (unsigned i = 0; i < 64; ++i) {
    const unsigned cell = child_shift(i >> 3) + child_shift(i & 7u) / 2;
    order[cell] = static_cast<std::uint8_t>(i);
  }
  return order;
}();
constexpr Cells in_order(Cells cells) {
  Cells ordered = 0;
  for (unsigned child = 0; child < 8; ++child)
    ordered |= Cells{mask_of(cells >> child_shift(child))} << 8 * child;
  return ordered;
}

/// What is around a cell or a brick, and itself, has the number 1 + x + 3 (1 + y) + 9 (1 + z) with
/// each coordinate from -1 to 1.
constexpr std::size_t number_around(const std::array<int, 3>& at) {
  return static_cast<std::size_t>(1 + at[0] + 3 * (1 + at[1]) + 9 * (1 + at[2]));
}
constexpr std::array<int, 3> place_around(std::size_t number) {
  const int n = static_cast<int>(number);
  return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
}
constexpr std::size_t kMiddle = number_around({0, 0, 0});

/// For each cell of a brick, the cell that lies `distance` further along a line. Together these are
/// parts of up to eight bricks around it, moved.
struct Move {
  struct Part {
    std::uint8_t brick;  ///< its number around the brick
    std::int8_t ahead;   ///< cell i is seen from cell i - ahead, if the mask has that
    Cells seen_from;
  };
  std::array<Part, 8> parts{};
  unsigned count = 0;

  constexpr Move() = default;
  constexpr Move(const std::array<int, 3>& line, int distance) {
    for (unsigned crossing = 0; crossing < 8; ++crossing) {
      // For each axis, whether the cells that are seen lie in the next brick.
      std::array<int, 3> step{}, brick{};
      bool possible = true;
      for (unsigned axis = 0; axis < 3; ++axis) {
        const bool crosses = (crossing >> axis & 1u) != 0;
        possible = possible && (line[axis] != 0 || !crosses);
        brick[axis] = crosses ? line[axis] : 0;
        step[axis] = distance * line[axis] - 4 * brick[axis];
      }
      if (!possible) continue;
      Part part{static_cast<std::uint8_t>(number_around(brick)),
                static_cast<std::int8_t>(step[0] + 4 * step[1] + 16 * step[2]), 0};
      for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 4; ++y) {
          for (int x = 0; x < 4; ++x) {
            const auto inside = [](int c) { return c >= 0 && c < 4; };
            if (inside(x + step[0]) && inside(y + step[1]) && inside(z + step[2]))
              part.seen_from |= Cells{1} << cell_number(x, y, z);
          }
        }
      }
      parts[count++] = part;
    }
  }
};

/// Moves the cells of a part's brick to the cells that they are seen from. Bits that are shifted
/// out come in on the other side, where the mask drops them.
constexpr Cells seen(const Move::Part& part, Cells cells) {
  const auto ahead = static_cast<unsigned>(part.ahead) & 63u;
  return (cells >> ahead | cells << (-ahead & 63u)) & part.seen_from;
}

/// The widest gap that is filled.
constexpr int kWidest = 3;

/// The 13 lines, each in both directions, by distances of 1 to kWidest.
constexpr std::size_t kLines = 13;
struct Line {
  std::array<std::array<Move, kWidest>, 2> moves;  ///< forwards, backwards
};
constexpr auto kMoves = [] {
  std::array<Line, kLines> lines{};
  for (std::size_t i = 0; i < kLines; ++i) {
    const std::array<int, 3> forwards = place_around(kMiddle + 1 + i);
    for (int sign : {1, -1}) {
      const std::array<int, 3> line = {sign * forwards[0], sign * forwards[1], sign * forwards[2]};
      for (int distance = 1; distance <= kWidest; ++distance) {
        lines[i].moves[sign > 0 ? 0 : 1][static_cast<std::size_t>(distance - 1)] =
            Move(line, distance);
      }
    }
  }
  return lines;
}();

/// Two cells that are two apart along one axis at least and one apart along another, such as a
/// knight's move, have no cell exactly between them. Those nearest to the middle are one of them,
/// `middle`, and others. All are given as what is around `middle`.
struct UnevenPair {
  std::array<std::uint8_t, 2> ends{};
  std::array<std::uint8_t, 3> others{};
  unsigned other_count = 0;
};
constexpr std::size_t kUnevenPairs = 36;
constexpr auto kUneven = [] {
  std::array<UnevenPair, kUnevenPairs> pairs{};
  std::size_t count = 0;
  const auto number = [](const std::array<int, 3>& at) {
    return static_cast<std::uint8_t>(number_around(at));
  };
  // Each pair once: of a step and its opposite, the one with the greater number.
  for (int step = 63; step < 125; ++step) {
    const std::array<int, 3> d = {step % 5 - 2, step / 5 % 5 - 2, step / 25 - 2};
    bool two = false;
    std::array<int, 3> odd{}, first{}, second{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      two = two || d[axis] == 2 || d[axis] == -2;
      odd[axis] = d[axis] & 1;
      second[axis] = (d[axis] + odd[axis]) / 2;
      first[axis] = second[axis] - d[axis];
    }
    if (!two || odd == std::array{0, 0, 0}) continue;
    UnevenPair& pair = pairs[count++];
    pair.ends = {number(first), number(second)};
    for (unsigned other = 1; other < 8; ++other) {
      const std::array<int, 3> at = {static_cast<int>(other & 1u),
                                     static_cast<int>(other >> 1 & 1u),
                                     static_cast<int>(other >> 2)};
      if (at[0] <= odd[0] && at[1] <= odd[1] && at[2] <= odd[2])
        pair.others[pair.other_count++] = number(at);
    }
  }
  return pairs;
}();

}  // namespace pointreel
