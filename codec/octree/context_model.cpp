#include "codec/octree/context_model.h"

#include <cmath>

#include "common/base/byte_io.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kMaxCells = 1u << 18, kMaxLeaves = 1u << 20;
constexpr int kMaxMaskBits = 20;

/// 65536 / (1 + exp(-x)) for 64 values of x from -7.2 to 7.2, rounded. They are listed because the
/// encoded bytes depend on them, and exp does not return the same everywhere.
constexpr std::array<std::uint16_t, 64> kProbabilities = {
    49,    61,    77,    97,    122,   153,   192,   241,   303,   381,   478,   599,   751,
    941,   1179,  1475,  1843,  2299,  2864,  3559,  4412,  5451,  6707,  8214,  10001, 12096,
    14514, 17260, 20318, 23652, 27205, 30898, 34638, 38331, 41884, 45218, 48276, 51022, 53440,
    55535, 57322, 58829, 60085, 61124, 61977, 62672, 63237, 63693, 64061, 64357, 64595, 64785,
    64937, 65058, 65155, 65233, 65295, 65344, 65383, 65414, 65439, 65459, 65475, 65487};

/// The number of decisions that a leaf reflects at the beginning, by confidence.
constexpr std::array<std::uint16_t, 4> kCounts = {1, 3, 8, 16};

constexpr std::array<double, kLevelClasses - 1> kBranching = {1.15, 1.5, 2.0, 2.6, 3.2};

}  // namespace

int level_class(std::size_t nodes, std::size_t children) {
  int result = 0;
  while (result < kLevelClasses - 1 &&
         static_cast<double>(children) >=
             kBranching[static_cast<std::size_t>(result)] * static_cast<double>(nodes)) {
    ++result;
  }
  return result;
}

Leaf unpack_leaf(std::uint8_t packed) {
  return {kProbabilities[packed >> 2], kCounts[packed & 3u]};
}

std::uint8_t pack_leaf(double probability, double decisions) {
  const double scaled = probability * 65536.0;
  std::size_t best = 0;
  // The nearest in log odds is the first whose geometric mean with the next is larger.
  while (best + 1 < kProbabilities.size()) {
    const double a = kProbabilities[best], b = kProbabilities[best + 1];
    const double odds = scaled / (65536.0 - scaled);
    if (odds * odds < a / (65536.0 - a) * (b / (65536.0 - b))) break;
    ++best;
  }
  const unsigned confidence = decisions < 3.0 ? 0 : decisions < 12.0 ? 1 : decisions < 60.0 ? 2 : 3;
  return static_cast<std::uint8_t>(best << 2 | confidence);
}

Result<ContextTables> parse_tables(ByteView bytes, const ContextTables* base) {
  const auto valid = [](std::uint64_t mask) {
    return mask >> neighborhood::kBits == 0 && std::popcount(mask) <= kMaxMaskBits;
  };
  ByteReader reader(bytes);
  ContextTables tables;
  // For a slot that is taken from the base, the base's slot; otherwise null.
  std::array<const ContextTables::Slot*, kLevelClasses * kSlots> of_base{};
  std::uint32_t cells = 0, own_cells = 0, leaves = 0;
  for (std::size_t i = 0; i < of_base.size(); ++i) {
    ContextTables::Slot& slot = tables.slots[i / kSlots][i % kSlots];
    slot.mask = reader.get<std::uint64_t>();
    if (base != nullptr && slot.mask == kBaseSlot) {
      of_base[i] = &base->slots[i / kSlots][i % kSlots];
      slot.mask = of_base[i]->mask;
    }
    if (!valid(slot.mask)) return fail("context tables have a mask out of range");
    slot.first_cell = cells;
    cells += 1u << std::popcount(slot.mask);
    if (of_base[i] == nullptr) own_cells += 1u << std::popcount(slot.mask);
    if (cells > kMaxCells) return fail(ErrorCode::limit, "context tables have too many cells");
  }
  if (reader.rest().size() < own_cells * sizeof(std::uint64_t)) {
    return fail("context tables are cut short");
  }
  tables.cells.resize(cells);
  ByteView packed = reader.rest().subspan(own_cells * sizeof(std::uint64_t));
  for (std::size_t i = 0; i < of_base.size(); ++i) {
    const ContextTables::Slot& slot = tables.slots[i / kSlots][i % kSlots];
    for (std::uint32_t c = 0; c < 1u << std::popcount(slot.mask); ++c) {
      ContextTables::Cell& cell = tables.cells[slot.first_cell + c];
      const ContextTables::Cell* theirs =
          of_base[i] != nullptr ? &base->cells[of_base[i]->first_cell + c] : nullptr;
      cell.mask = theirs != nullptr ? theirs->mask : reader.get<std::uint64_t>();
      if (!valid(cell.mask)) return fail("context tables have a mask out of range");
      const std::uint32_t count = 1u << std::popcount(cell.mask);
      cell.first_leaf = leaves;
      leaves += count;
      if (leaves > kMaxLeaves) {
        return fail(ErrorCode::limit, "context tables have too many leaves");
      }
      if (theirs != nullptr) {
        const auto from = base->leaves.begin() + theirs->first_leaf;
        tables.leaves.insert(tables.leaves.end(), from, from + count);
        continue;
      }
      if (packed.size() < count) return fail("context tables have too few leaves");
      for (const std::uint8_t leaf : packed.first(count)) {
        tables.leaves.push_back(unpack_leaf(leaf));
      }
      packed = packed.subspan(count);
    }
  }
  if (!packed.empty()) return fail("context tables have bytes after their last leaf");
  return tables;
}

Bytes write_tables(std::span<const SlotTables, kLevelClasses * kSlots> slots) {
  Bytes bytes;
  ByteWriter writer(bytes);
  for (const SlotTables& slot : slots) writer.put(slot.mask);
  for (const SlotTables& slot : slots) {
    for (const std::uint64_t mask : slot.cells) writer.put(mask);
  }
  for (const SlotTables& slot : slots) {
    bytes.insert(bytes.end(), slot.leaves.begin(), slot.leaves.end());
  }
  return bytes;
}

}  // namespace pointreel
