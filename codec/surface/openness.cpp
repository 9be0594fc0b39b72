#include "codec/surface/openness.h"

#include <algorithm>
#include <bit>

namespace pointreel {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

/// A word of a row that is moved by one cell to higher (dx = 1) or lower (dx = -1) x. Cells that
/// enter at the border are open.
inline std::uint64_t moved(const std::uint64_t* row, std::size_t word, std::size_t words, int dx) {
  if (dx > 0) return row[word] << 1 | (word > 0 ? row[word - 1] >> 63 : 1u);
  if (dx < 0) return row[word] >> 1 | (word + 1 < words ? row[word + 1] << 63 : kAll << 63);
  return row[word];
}

}  // namespace

Openness::Openness(const Svo& svo, int level)
    : side_(1 << level),
      words_(static_cast<std::size_t>(side_ + 63) / 64),
      cell_size_(svo.cell_size(level)),
      cells_per_unit_(1.0 / cell_size_) {
  const auto side = static_cast<std::size_t>(side_);
  empty_.assign(words_ * side * side, kAll);
  for (const glm::uvec3& cell : leaf_cells(truncate(svo, level))) {
    const std::size_t row = (std::size_t{cell.z} * side + cell.y) * words_;
    empty_[row + cell.x / 64] &= ~(std::uint64_t{1} << (cell.x % 64));
  }
  counts_.assign(empty_.size(), {});
  std::vector<std::uint64_t> open(empty_.size());
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        sweep({dx, dy, dz}, open);
        count(open);
      }
    }
  }
}

void Openness::sweep(const glm::ivec3& direction, std::vector<std::uint64_t>& open) const {
  const auto row_at = [this](int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(side_) +
            static_cast<std::size_t>(y)) *
           words_;
  };
  const std::vector<std::uint64_t> border(words_, kAll);
  for (int i = 0; i < side_; ++i) {
    const int z = direction.z > 0 ? i : side_ - 1 - i;
    const int from_z = z - direction.z;
    for (int k = 0; k < side_; ++k) {
      const int y = direction.y > 0 ? k : side_ - 1 - k;
      const int from_y = y - direction.y;
      const std::uint64_t* empty = empty_.data() + row_at(y, z);
      std::uint64_t* to = open.data() + row_at(y, z);
      if (direction.y == 0 && direction.z == 0) {
        // The direction runs along the row: all cells before the first occupied one are open.
        bool clear = true;
        for (std::size_t j = 0; j < words_; ++j) {
          const std::size_t word = direction.x > 0 ? j : words_ - 1 - j;
          const std::uint64_t full = ~empty[word];
          if (!clear) {
            to[word] = 0;
          } else if (full == 0) {
            to[word] = kAll;
          } else {
            const int before = direction.x > 0 ? std::countr_zero(full) : std::countl_zero(full);
            to[word] = before == 0       ? 0
                       : direction.x > 0 ? kAll >> (64 - before)
                                         : kAll << (64 - before);
            clear = false;
          }
        }
        continue;
      }
      const bool inside = from_y >= 0 && from_y < side_ && from_z >= 0 && from_z < side_;
      const std::uint64_t* from = inside ? open.data() + row_at(from_y, from_z) : border.data();
      for (std::size_t word = 0; word < words_; ++word) {
        to[word] = empty[word] & moved(from, word, words_, direction.x);
      }
    }
  }
}

void Openness::count(const std::vector<std::uint64_t>& open) {
  for (std::size_t i = 0; i < open.size(); ++i) {
    std::uint64_t carry = open[i];
    for (std::uint64_t& digit : counts_[i]) {
      const std::uint64_t sum = digit ^ carry;
      carry &= digit;
      digit = sum;
    }
  }
}

int Openness::at(const glm::vec3& p) const {
  const glm::dvec3 scaled = glm::dvec3(p) * cells_per_unit_;
  // Compared before the conversion to integers, which could overflow.
  const auto inside = [this](double v) { return v >= 0.0 && v < static_cast<double>(side_); };
  if (!inside(scaled.x) || !inside(scaled.y) || !inside(scaled.z)) return 26;
  const glm::uvec3 cell(scaled);
  const auto side = static_cast<std::size_t>(side_);
  const std::size_t word = (cell.z * side + cell.y) * words_ + cell.x / 64;
  int value = 0;
  for (std::size_t digit = 0; digit < 5; ++digit) {
    value |= static_cast<int>(counts_[word][digit] >> (cell.x % 64) & 1u) << digit;
  }
  return value;
}

}  // namespace pointreel
