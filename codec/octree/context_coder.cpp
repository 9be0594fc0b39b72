#include "codec/octree/context_coder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string>
#include <utility>

#include "codec/octree/bit_extract.h"
#include "codec/octree/range_coder.h"

namespace pointreel {
namespace {

#if defined(__x86_64__)
/// Compiles all that a function calls for processors with BMI2, whose shifts take fewer steps too.
#define POINTREEL_BMI2 [[gnu::flatten, gnu::target("bmi2")]]
#endif

bool use_hardware(ExtractPath path) {
#if defined(__x86_64__)
  return path == ExtractPath::fastest && HardwareExtract::available();
#else
  (void)path;
  return false;
#endif
}

/// Rank of each node's first child, the masks being those of one level in Morton order. Returns the
/// number of all children.
std::size_t number_children(ByteView masks, std::vector<std::uint32_t>& first_child) {
  first_child.resize(masks.size());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    first_child[i] = next;
    next += static_cast<std::uint32_t>(std::popcount(masks[i]));
  }
  return next;
}

/// The masks of one level are in `masks` from `begin` on, in Morton order: on to the level below.
void descend(RasterLevel& level, ByteView masks) {
  std::vector<std::uint32_t> first_child;
  const std::size_t children = number_children(masks, first_child);
  RasterLevel below;
  expand(level, first_child, children, below);
  level = std::move(below);
}

/// A decision to code: 2 leaf + bit.
using Decision = std::uint32_t;

/// Not inlined: alone the loop's state fits the registers.
[[gnu::noinline]] void code_decisions(std::span<const Decision> decisions, Leaf* leaves,
                                      RangeEncoder& shared_encoder) {
  RangeEncoder encoder = shared_encoder;
  for (const Decision decision : decisions) {
    Leaf& leaf = leaves[decision >> 1];
    encoder.encode(decision & 1u, leaf.probability);
    adapt(leaf, decision & 1u);
  }
  shared_encoder = encoder;
}

/// Unlike a decoder, an encoder knows what follows. It first gathers the decisions of some nodes,
/// whose look-ups do not wait for each other, and then codes them, each of which waits for the one
/// before.
template <class Extract>
void encode_level(const ContextTables& tables, int level_class, std::vector<Leaf>& leaves,
                  RasterLevel& level, RangeEncoder& encoder) {
  constexpr std::size_t kNodes = 64, kMostDecisions = 9;  // at a time; of a node
  const ContextLookup<Extract> lookup(tables, level_class, leaves);
  const bool only_child_first = codes_only_child(level_class);
  const std::uint8_t* masks = level.masks.data();
  const std::uint32_t* parents = level.parents.data();
  std::array<Decision, kNodes * kMostDecisions> decisions;
  walk_known(level, [&](std::uint32_t begin, std::span<const std::uint64_t> words) {
    for (std::size_t first = 0; first < words.size(); first += kNodes) {
      const std::size_t end = std::min(first + kNodes, words.size());
      Decision* next = decisions.data();
      for (std::size_t i = first; i < end; ++i) {
        const std::size_t node = begin + i;
        const std::uint64_t word =
            only_child_first ? neighborhood::sparse_word(words[i], parents[node]) : words[i];
        for_each_decision(only_child_first, word, masks[node],
                          [&](int slot, std::uint64_t context, unsigned bit) {
                            *next++ = 2 * lookup.number(slot, context) + bit;
                          });
      }
      code_decisions({decisions.data(), next}, leaves.data(), encoder);
    }
  });
}

#if defined(__x86_64__)
POINTREEL_BMI2 void encode_level_bmi2(const ContextTables& tables, int level_class,
                                      std::vector<Leaf>& leaves, RasterLevel& level,
                                      RangeEncoder& encoder) {
  encode_level<HardwareExtract>(tables, level_class, leaves, level, encoder);
}
#endif

/// One node's mask. Where the next decision's context depends on the bit that is being decoded,
/// both leaves are looked up beforehand: the look-ups then take place while the bit is decoded.
template <class Lookup>
[[gnu::always_inline]] inline std::uint32_t decode_node(const Lookup& lookup, bool only_child_first,
                                                        std::uint64_t word, RangeDecoder& decoder) {
  const auto decode = [&decoder](Leaf& leaf) {
    const unsigned bit = decoder.decode(leaf.probability);
    adapt(leaf, bit);
    return bit;
  };
  Leaf* leaf = &lookup(0, word);
  if (only_child_first) {
    std::array<std::uint32_t, 7> position;  // leaves of the slots from kPositionSlot on
    for (int slot = 0; slot < 7; ++slot) {
      position[static_cast<std::size_t>(slot)] = lookup.number(kPositionSlot + slot, word);
    }
    if (decode(lookup(kOnlyChildSlot, word)) != 0) {
      // Where the only child is can hardly be guessed: no branch may depend on it.
      const auto choose = [](unsigned bit, std::uint32_t zero, std::uint32_t one) {
        return zero ^ ((zero ^ one) & (0u - bit));
      };
      const auto decode_leaf = [&lookup, &decoder](std::uint32_t number) {
        Leaf& found = lookup.leaf(number);
        const unsigned bit = decoder.decode_without_branch(found.probability);
        adapt(found, bit);
        return bit;
      };
      const auto [high, middle0, middle1, low0, low1, low2, low3] = position;
      const unsigned z = decode_leaf(high);
      const std::uint32_t low_0 = choose(z, low0, low2), low_1 = choose(z, low1, low3);
      const unsigned y = decode_leaf(choose(z, middle0, middle1));
      const unsigned x = decode_leaf(choose(y, low_0, low_1));
      return 1u << (4 * z + 2 * y + x);
    }
  }
  std::uint32_t own = 0;
  for (int child = 0; child < 6; ++child) {
    const std::uint64_t known = word | std::uint64_t{own} << neighborhood::kOwn;
    Leaf& without = lookup(child + 1, known);
    Leaf& with = lookup(child + 1, known | std::uint64_t{1} << (neighborhood::kOwn + child));
    const unsigned bit = decode(*leaf);
    own |= bit << child;
    leaf = bit != 0 ? &with : &without;
  }
  if (only_child_first && own == 0) return 0xc0u;
  const std::uint64_t known = word | std::uint64_t{own} << neighborhood::kOwn;
  Leaf& without = lookup(7, known);
  Leaf& with = lookup(7, known | std::uint64_t{1} << (neighborhood::kOwn + 6));
  const unsigned bit = decode(*leaf);
  own |= bit << 6;
  const std::uint32_t least = only_child_first ? 2 : 1;
  if (static_cast<std::uint32_t>(std::popcount(own)) < least) return own | 0x80u;
  return own | decode(bit != 0 ? with : without) << 7;
}

/// Into level.masks; the number of all children.
template <class Extract>
std::size_t decode_level(const ContextTables& tables, int level_class, std::vector<Leaf>& leaves,
                         RasterLevel& level, RangeDecoder& shared_decoder) {
  const ContextLookup<Extract> lookup(tables, level_class, leaves);
  const bool only_child_first = codes_only_child(level_class);
  RangeDecoder decoder = shared_decoder;
  const std::uint32_t* parents = level.parents.data();
  std::size_t children = 0;
  walk(level, [&](std::uint32_t node, std::uint64_t word) {
    if (only_child_first) word = neighborhood::sparse_word(word, parents[node]);
    const std::uint32_t mask = decode_node(lookup, only_child_first, word, decoder);
    children += static_cast<unsigned>(std::popcount(mask));
    return mask;
  });
  shared_decoder = decoder;
  return children;
}

#if defined(__x86_64__)
POINTREEL_BMI2 std::size_t decode_level_bmi2(const ContextTables& tables, int level_class,
                                             std::vector<Leaf>& leaves, RasterLevel& level,
                                             RangeDecoder& decoder) {
  return decode_level<HardwareExtract>(tables, level_class, leaves, level, decoder);
}
#endif

}  // namespace

ContextEncoder::ContextEncoder(std::shared_ptr<const ContextTables> tables, ExtractPath path)
    : tables_(std::move(tables)),
      leaves_(tables_->leaves),
      level_(root_level()),
      hardware_(use_hardware(path)) {}

void ContextEncoder::encode_layer(const Svo& svo, int first_level, int last_level, Bytes& payload) {
  const auto class_of = [&svo](int level) {
    return level_class(svo.node_count(level), svo.node_count(level + 1));
  };
  for (int level = first_level; level < last_level; ++level) {
    payload.push_back(static_cast<std::uint8_t>(class_of(level)));
  }
  RangeEncoder encoder(payload);
  for (int level = first_level; level < last_level; ++level) {
    if (level > 0) {
      const std::size_t above = static_cast<std::size_t>(level) - 1;
      descend(level_, ByteView(svo.masks).subspan(svo.level_begin[above], level_.size()));
    }
    const std::uint8_t* masks = svo.masks.data() + svo.level_begin[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < level_.size(); ++i) level_.masks[i] = masks[level_.rank[i]];
    const int level_class = class_of(level);
#if defined(__x86_64__)
    if (hardware_) {
      encode_level_bmi2(*tables_, level_class, leaves_, level_, encoder);
      continue;
    }
#endif
    encode_level<PortableExtract>(*tables_, level_class, leaves_, level_, encoder);
  }
  encoder.finish();
}

ContextDecoder::ContextDecoder(std::shared_ptr<const ContextTables> tables, ExtractPath path)
    : tables_(std::move(tables)),
      leaves_(tables_->leaves),
      level_(root_level()),
      hardware_(use_hardware(path)) {}

Result<void> ContextDecoder::decode_layer(ByteView payload, int first_level, int last_level,
                                          std::size_t mask_count, std::size_t most_nodes,
                                          Bytes& masks) {
  const std::size_t levels = static_cast<std::size_t>(last_level - first_level);
  if (payload.size() < levels) return fail("chunk's level classes are cut short");
  const ByteView classes = payload.first(levels);
  RangeDecoder decoder(payload.subspan(levels));
  std::size_t left = mask_count;
  for (int level = first_level; level < last_level; ++level) {
    const int level_class = classes[static_cast<std::size_t>(level - first_level)];
    if (level_class >= kLevelClasses) {
      return fail("chunk has unknown level class " + std::to_string(level_class));
    }
    if (level > 0) descend(level_, ByteView(masks).last(level_.size()));
    if (level_.size() > left) return fail("level sizes disagree with the masks");
    left -= level_.size();
    std::size_t children = 0;
#if defined(__x86_64__)
    if (hardware_) {
      children = decode_level_bmi2(*tables_, level_class, leaves_, level_, decoder);
    } else {
      children = decode_level<PortableExtract>(*tables_, level_class, leaves_, level_, decoder);
    }
#else
    children = decode_level<PortableExtract>(*tables_, level_class, leaves_, level_, decoder);
#endif
    if (children > most_nodes) return fail("more nodes than the header has points");
    const std::size_t begin = masks.size();
    masks.resize(begin + level_.size());
    for (std::size_t i = 0; i < level_.size(); ++i) {
      masks[begin + level_.rank[i]] = level_.masks[i];
    }
  }
  if (left != 0) return fail("level sizes disagree with the masks");
  if (!decoder.complete()) return fail("chunk's range coded data is damaged");
  return {};
}

}  // namespace pointreel
