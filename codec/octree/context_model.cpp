#include "codec/octree/context_model.h"

#include <bit>

#include "common/base/byte_io.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kMostAlphabets = 1u << 16;

/// How many symbols an alphabet is worth at the beginning, by confidence.
constexpr std::array<int, 4> kSeen = {5, 11, 25, 57};
/// The frequencies that a rarity stands for. They lie closer together where more symbols are coded.
constexpr std::array<std::uint32_t, 16> kFrequencies = {
    1005861, 912838, 794672, 668237, 542777, 425854, 322737, 236257,
    167059,  114105, 72717,  43238,  23170,  10086,  2896,   362};

constexpr std::array<double, kLevelClasses - 1> kBranching = {1.15, 1.5, 2.0, 2.6, 3.2};

bool valid(std::uint64_t mask, int table, int most_bits) {
  const bool causal = is_causal_table(table);
  return mask >> (causal ? causal_word::kBits : sparse_word::kBits) == 0 &&
         std::popcount(mask) <= most_bits;
}

}  // namespace

int level_class(int level, std::size_t nodes, std::size_t children) {
  const int most = may_be_causal(level, nodes) ? kLevelClasses - 1 : kFirstCausalClass - 1;
  int result = 0;
  while (result < most &&
         static_cast<double>(children) >=
             kBranching[static_cast<std::size_t>(result)] * static_cast<double>(nodes)) {
    ++result;
  }
  return result;
}

Alphabet16 unpack_alphabet(const StoredAlphabet& stored, int symbols) {
  std::array<std::uint32_t, 16> counts{};
  for (std::size_t s = 0; s < static_cast<std::size_t>(symbols); ++s) {
    counts[s] = kFrequencies[stored.rarity[s] & 15u];
  }
  return {counts, kSeen[stored.confidence & 3u]};
}

std::uint8_t rarity_of(double share) {
  const double square = share * share * 1048576.0 * 1048576.0;
  std::size_t rarity = 0;
  while (rarity + 1 < kFrequencies.size() &&
         square < static_cast<double>(kFrequencies[rarity]) * kFrequencies[rarity + 1]) {
    ++rarity;
  }
  return static_cast<std::uint8_t>(rarity);
}

namespace {

/// Reads tables one after another. Those that the bytes lack are copied from the base.
class TablesReader {
 public:
  TablesReader(ByteView bytes, const ContextTables* base) : reader_(bytes), base_(base) {}

  Result<ContextTables> read() {
    for (int t = 0; t < kTables; ++t) TRY(read_table(t));
    if (!reader_.rest().empty()) return fail("context tables have bytes after their end");
    return std::move(all_);
  }

 private:
  Result<void> read_table(int t) {
    ContextTables::Table& table = all_.tables[static_cast<std::size_t>(t)];
    table.first_cell = static_cast<std::uint32_t>(all_.cells.size());
    const auto mask = reader_.get<std::uint64_t>();
    if (base_ != nullptr && mask == kBaseTable) {
      return copy_table(base_->tables[static_cast<std::size_t>(t)], table);
    }
    if (!valid(mask, t, ContextTables::kMostTableBits)) return out_of_range();
    table.bits = WordBits<ContextTables::kMostTableBits>(mask);
    const std::size_t cells = std::size_t{1} << std::popcount(mask);
    const std::size_t parts = TRY(read_masks(t, cells, all_.parts.size(), all_.cells));
    const std::size_t alphabets = TRY(read_masks(t, parts, all_.alphabets.size(), all_.parts));
    const auto symbols = static_cast<std::size_t>(symbols_of_table(t));
    const ByteView packed = reader_.rest();
    if (packed.size() / (symbols + 1) < alphabets) return fail("context tables are cut short");
    for (std::size_t a = 0; a < alphabets; ++a) {
      StoredAlphabet stored{packed[a], {}};
      for (std::size_t s = 0; s < symbols; ++s) stored.rarity[s] = packed[(s + 1) * alphabets + a];
      all_.alphabets.push_back(unpack_alphabet(stored, static_cast<int>(symbols)));
    }
    reader_ = ByteReader(packed.subspan(alphabets * (symbols + 1)));
    return {};
  }

  /// Reads the masks of `count` cells or parts, the first of which leads to number `next`. Returns
  /// to how many they lead.
  Result<std::size_t> read_masks(int t, std::size_t count, std::size_t next,
                                 std::vector<ContextTables::Cell>& cells) {
    if (reader_.rest().size() / sizeof(std::uint64_t) < count) {
      return fail("context tables are cut short");
    }
    const std::size_t first = next;
    for (std::size_t c = 0; c < count; ++c) {
      const auto mask = reader_.get<std::uint64_t>();
      if (!valid(mask, t, ContextTables::kMostCellBits)) return out_of_range();
      cells.push_back(
          {WordBits<ContextTables::kMostCellBits>(mask), static_cast<std::uint32_t>(next)});
      next += std::size_t{1} << std::popcount(mask);
    }
    if (next > kMostAlphabets) return too_many();
    return next - first;
  }

  /// Part of a vector.
  struct Range {
    std::size_t begin, count;
  };

  /// Copies cells or parts, which shall lead to number `next` on. Returns to what they led.
  static Range copy_cells(const std::vector<ContextTables::Cell>& from, Range range,
                          std::size_t next, std::vector<ContextTables::Cell>& to) {
    const std::size_t first = from[range.begin].first;
    for (std::size_t i = range.begin; i < range.begin + range.count; ++i) {
      to.push_back({from[i].bits, static_cast<std::uint32_t>(from[i].first - first + next)});
    }
    const ContextTables::Cell& last = from[range.begin + range.count - 1];
    return {first, last.first + (std::size_t{1} << std::popcount(last.bits.mask)) - first};
  }

  Result<void> copy_table(const ContextTables::Table& from, ContextTables::Table& to) {
    to.bits = from.bits;
    const Range cells{from.first_cell, std::size_t{1} << std::popcount(from.bits.mask)};
    const Range parts = copy_cells(base_->cells, cells, all_.parts.size(), all_.cells);
    const Range alphabets = copy_cells(base_->parts, parts, all_.alphabets.size(), all_.parts);
    const auto begin = base_->alphabets.begin() + static_cast<std::ptrdiff_t>(alphabets.begin);
    all_.alphabets.insert(all_.alphabets.end(), begin,
                          begin + static_cast<std::ptrdiff_t>(alphabets.count));
    if (all_.alphabets.size() > kMostAlphabets) return too_many();
    return {};
  }

  static tl::unexpected<Error> out_of_range() {
    return fail("context tables have a mask out of range");
  }
  static tl::unexpected<Error> too_many() {
    return fail(ErrorCode::limit, "context tables have too many alphabets");
  }

  ByteReader reader_;
  const ContextTables* base_;
  ContextTables all_;
};

}  // namespace
Result<ContextTables> parse_tables(ByteView bytes, const ContextTables* base) {
  return TablesReader(bytes, base).read();
}

Bytes write_tables(std::span<const StoredTable, kTables> tables) {
  Bytes bytes;
  ByteWriter writer(bytes);
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const StoredTable& table = tables[t];
    writer.put(table.mask);
    for (const std::uint64_t mask : table.cells) writer.put(mask);
    for (const std::uint64_t mask : table.parts) writer.put(mask);
    for (const StoredAlphabet& a : table.alphabets) bytes.push_back(a.confidence);
    const auto symbols = static_cast<std::size_t>(symbols_of_table(static_cast<int>(t)));
    for (std::size_t s = 0; s < (table.mask == kBaseTable ? 0 : symbols); ++s) {
      for (const StoredAlphabet& a : table.alphabets) bytes.push_back(a.rarity[s]);
    }
  }
  return bytes;
}

}  // namespace pointreel
