#include "codec/octree/context_coder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "codec/octree/bit_extract.h"
#include "codec/octree/range_coder.h"
#include "codec/octree/slabs.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/for_each.h"
#include "common/base/try.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

#if defined(__x86_64__)
/// Compiles a function and everything that it calls for processors with BMI2, whose shifts are
/// faster too.
#define POINTREEL_BMI2 [[gnu::flatten, gnu::target("bmi2")]]
#endif

/// Computes the rank of each node's first child from the masks of a level in Morton order. Returns
/// the number of all children.
std::size_t number_children(ByteView masks, std::vector<std::uint32_t>& first_child) {
  first_child.resize(masks.size());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    first_child[i] = next;
    next += static_cast<std::uint32_t>(std::popcount(masks[i]));
  }
  return next;
}

/// A decision to be coded: 2 * leaf + bit.
using Decision = std::uint32_t;

/// Not inlined, so that the state of the loop fits into registers.
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

/// Unlike a decoder, an encoder knows the decisions beforehand. It first collects those of some
/// nodes, whose look-ups are independent of each other, and then codes them, where each step has to
/// wait for the one before.
template <class Extract>
void encode_nodes(const ContextTables& tables, int level_class, std::vector<Leaf>& leaves,
                  const RasterLevel& level, LevelWalk& walk, std::size_t count,
                  RangeEncoder& encoder) {
  constexpr std::size_t kNodes = 64;         // to collect at a time
  constexpr std::size_t kMostDecisions = 9;  // of a node
  const ContextLookup<Extract> lookup(tables, level_class, leaves);
  const bool only_child_first = codes_only_child(level_class);
  const std::uint8_t* masks = level.masks.data();
  const std::uint32_t* parents = level.parents.data();
  std::array<Decision, kNodes * kMostDecisions> decisions;
  walk.visit_known(count, [&](std::uint32_t begin, std::span<const std::uint64_t> words) {
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
POINTREEL_BMI2 void encode_nodes_bmi2(const ContextTables& tables, int level_class,
                                      std::vector<Leaf>& leaves, const RasterLevel& level,
                                      LevelWalk& walk, std::size_t count, RangeEncoder& encoder) {
  encode_nodes<HardwareExtract>(tables, level_class, leaves, level, walk, count, encoder);
}
#endif

/// Decodes the mask of a node. Where the context of the next decision depends on the bit that is
/// being decoded, the leaves for both values are looked up beforehand, so that the look-ups overlap
/// with decoding the bit.
template <class Lookup>
[[gnu::always_inline]] inline std::uint32_t decode_node(const Lookup& lookup, bool only_child_first,
                                                        std::uint64_t word, RangeDecoder& decoder) {
  // A branch on the bit, which is usually predicted correctly, lets the leaf adapt without waiting.
  const auto decode = [&decoder](Leaf& leaf) {
    if (decoder.decode(leaf.probability) != 0) {
      adapt(leaf, 1);
      return 1u;
    }
    adapt(leaf, 0);
    return 0u;
  };
  Leaf* leaf = &lookup(0, word);
  if (only_child_first) {
    std::array<std::uint32_t, 7> position;  // leaves of the slots from kPositionSlot on
    for (int slot = 0; slot < 7; ++slot) {
      position[static_cast<std::size_t>(slot)] = lookup.number(kPositionSlot + slot, word);
    }
    if (decode(lookup(kOnlyChildSlot, word)) != 0) {
      // The number of the only child is hard to predict, so no branch depends on it.
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

/// Decodes masks into level.masks. Returns the number of all children.
template <class Extract>
std::size_t decode_nodes(const ContextTables& tables, int level_class, std::vector<Leaf>& leaves,
                         const RasterLevel& level, LevelWalk& walk, std::size_t count,
                         RangeDecoder& shared_decoder) {
  const ContextLookup<Extract> lookup(tables, level_class, leaves);
  const bool only_child_first = codes_only_child(level_class);
  RangeDecoder decoder = shared_decoder;
  const std::uint32_t* parents = level.parents.data();
  std::size_t children = 0;
  walk.visit(count, [&](std::uint32_t node, std::uint64_t word) {
    if (only_child_first) word = neighborhood::sparse_word(word, parents[node]);
    const std::uint32_t mask = decode_node(lookup, only_child_first, word, decoder);
    children += static_cast<unsigned>(std::popcount(mask));
    return mask;
  });
  shared_decoder = decoder;
  return children;
}

#if defined(__x86_64__)
POINTREEL_BMI2 std::size_t decode_nodes_bmi2(const ContextTables& tables, int level_class,
                                             std::vector<Leaf>& leaves, const RasterLevel& level,
                                             LevelWalk& walk, std::size_t count,
                                             RangeDecoder& decoder) {
  return decode_nodes<HardwareExtract>(tables, level_class, leaves, level, walk, count, decoder);
}
#endif

/// Codes the current level. `code(slab, leaves, walk, count)` continues with a slab until `count`
/// of its nodes are coded in all.
template <class Code>
void code_level(ContextState& state, int level_class, const Executor& executor, Code&& code) {
  const int slabs = static_cast<int>(state.slabs.size());
  if (slabs == 1) {
    LevelWalk walk(state.slabs.front());
    code(std::size_t{0}, state.leaves, walk, kAllNodes);
    return;
  }
  const LeafRange range = leaves_of_class(*state.tables, level_class);
  const std::size_t share = (range.end - range.begin) / static_cast<std::size_t>(slabs) + 1;
  std::vector<std::optional<LevelWalk>> walks(state.slabs.size());
  std::vector<std::size_t> nodes(state.slabs.size());
  for (int phase = 0; phase < kPhases; ++phase) {
    for_each(executor, slabs, [&](int number) {
      const auto slab = static_cast<std::size_t>(number);
      if (phase == 0) {
        walks[slab].emplace(state.slabs[slab]);
        nodes[slab] = count_in_slab(state.slabs[slab]);
      }
      std::vector<Leaf>& leaves = state.slab_leaves[slab];
      std::copy(state.leaves.begin() + static_cast<std::ptrdiff_t>(range.begin),
                state.leaves.begin() + static_cast<std::ptrdiff_t>(range.end),
                leaves.begin() + static_cast<std::ptrdiff_t>(range.begin));
      code(slab, leaves, *walks[slab], nodes_of_phases(nodes[slab], phase));
    });
    for_each(executor, slabs, [&](int number) {
      const std::size_t begin = range.begin + share * static_cast<std::size_t>(number);
      const LeafRange part{begin, std::min(begin + share, range.end)};
      merge_leaves(state.slab_leaves, part, state.leaves);
    });
  }
}

/// For each node of a level in Morton order, the number of its descendants at the last level above
/// the leaves.
std::vector<std::uint32_t> weights_of_nodes(const Svo& svo, int level) {
  std::vector<std::uint32_t> weights(svo.node_count(level));
  std::uint32_t begin = svo.level_begin[static_cast<std::size_t>(svo.depth) - 1];
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    std::uint32_t end = svo.level_begin[static_cast<std::size_t>(level)] + i + 1;
    for (int below = level; below < svo.depth - 1; ++below) {
      const std::uint32_t level_end = svo.level_begin[static_cast<std::size_t>(below) + 1];
      end = end < level_end ? svo.first_child[end]
                            : svo.level_begin[static_cast<std::size_t>(below) + 2];
    }
    weights[i] = end - begin;
    begin = end;
  }
  return weights;
}

}  // namespace

// --- State ---

ContextState::ContextState(std::shared_ptr<const ContextTables> from)
    : tables(std::move(from)),
      leaves(tables->leaves),
      slabs{root_level()},
      hardware((cpu_features() & kCpuBmi2) != 0) {}

void ContextState::descend(ByteView masks, const Executor& executor) {
  std::vector<std::uint32_t> first_child;
  number_children(masks, first_child);
  for_each(executor, static_cast<int>(slabs.size()), [&](int slab) {
    RasterLevel& level = slabs[static_cast<std::size_t>(slab)];
    give_masks(level, masks, false);
    std::size_t children = 0;
    for (const std::uint8_t mask : level.masks) {
      children += static_cast<unsigned>(std::popcount(mask));
    }
    RasterLevel below;
    expand(level, first_child, children, below);
    level = std::move(below);
  });
}

void ContextState::begin_level(int level_class, std::size_t nodes) {
  constexpr std::size_t kLargeLevel = 16384;
  constexpr std::uint16_t kMostCount = 6;
  if (level_class != kLevelClasses - 1 || nodes < kLargeLevel) return;
  const LeafRange range = leaves_of_class(*tables, level_class);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    leaves[i].count = std::min(leaves[i].count, kMostCount);
  }
}

// --- Encoder ---

ContextEncoder::ContextEncoder(std::shared_ptr<const ContextTables> tables, int slabs)
    : state_(std::move(tables)), wanted_slabs_(slabs) {}

void ContextEncoder::write_slabs(const Svo& svo, int first_level, std::size_t mask_count,
                                 Bytes& payload) {
  ByteWriter writer(payload);
  const int most = static_cast<int>(
      std::min(mask_count / kLeastMasksOfSlab, static_cast<std::size_t>(wanted_slabs_)));
  const bool whole = state_.slabs.size() == 1;
  SlabCuts cuts;
  if (whole && first_level > 0 && most > 1) {
    cuts = choose_cuts(state_.slabs.front(), weights_of_nodes(svo, first_level), most);
    if (!cuts.begins.empty()) {
      state_.slabs = split(state_.slabs.front(), cuts);
      state_.slab_leaves.assign(state_.slabs.size(), state_.leaves);
    }
  }
  writer.put(static_cast<std::uint8_t>(state_.slabs.size()));
  if (!whole || state_.slabs.size() == 1) return;
  writer.put(static_cast<std::uint8_t>(cuts.axis));
  for (const std::uint32_t begin : cuts.begins) writer.put(static_cast<std::uint16_t>(begin));
}

void ContextEncoder::encode_layer(const Svo& svo, int first_level, int last_level, Bytes& payload,
                                  const Executor& executor) {
  const auto class_of = [&svo](int level) {
    return level_class(svo.node_count(level), svo.node_count(level + 1));
  };
  const auto masks_of = [&svo](int level) {
    return ByteView(svo.masks).subspan(svo.level_begin[static_cast<std::size_t>(level)],
                                       svo.node_count(level));
  };
  for (int level = first_level; level < last_level; ++level) {
    payload.push_back(static_cast<std::uint8_t>(class_of(level)));
  }
  if (first_level > 0) state_.descend(masks_of(first_level - 1), executor);
  write_slabs(svo, first_level,
              svo.level_begin[static_cast<std::size_t>(last_level)] -
                  svo.level_begin[static_cast<std::size_t>(first_level)],
              payload);
  std::vector<Bytes> streams(state_.slabs.size());
  std::vector<RangeEncoder> encoders(streams.begin(), streams.end());
  for (int level = first_level; level < last_level; ++level) {
    if (level > first_level) state_.descend(masks_of(level - 1), executor);
    const ByteView masks = masks_of(level);
    const int level_class = class_of(level);
    for_each(executor, static_cast<int>(state_.slabs.size()), [&](int number) {
      RasterLevel& slab = state_.slabs[static_cast<std::size_t>(number)];
      give_masks(slab, masks, true);
    });
    state_.begin_level(level_class, masks.size());
    code_level(
        state_, level_class, executor,
        [&](std::size_t slab, std::vector<Leaf>& leaves, LevelWalk& walk, std::size_t count) {
#if defined(__x86_64__)
          if (state_.hardware) {
            encode_nodes_bmi2(*state_.tables, level_class, leaves, state_.slabs[slab], walk, count,
                              encoders[slab]);
            return;
          }
#endif
          encode_nodes<PortableExtract>(*state_.tables, level_class, leaves, state_.slabs[slab],
                                        walk, count, encoders[slab]);
        });
  }
  for (RangeEncoder& encoder : encoders) encoder.finish();
  ByteWriter writer(payload);
  for (std::size_t slab = 0; slab + 1 < streams.size(); ++slab) {
    writer.put(static_cast<std::uint32_t>(streams[slab].size()));
  }
  for (const Bytes& stream : streams) {
    payload.insert(payload.end(), stream.begin(), stream.end());
  }
}

// --- Decoder ---

ContextDecoder::ContextDecoder(std::shared_ptr<const ContextTables> tables)
    : state_(std::move(tables)) {}

Result<std::vector<RangeDecoder>> ContextDecoder::read_slabs(ByteReader& reader,
                                                             std::size_t mask_count,
                                                             MemoryBudget* budget) {
  const std::size_t slabs = reader.get<std::uint8_t>();
  if (slabs != state_.slabs.size()) {
    if (state_.slabs.size() > 1 || slabs == 0 || slabs > kMostSlabs ||
        slabs * kLeastMasksOfSlab > mask_count) {
      return fail(concat("chunk cannot have ", slabs, " slabs"));
    }
    SlabCuts cuts;
    cuts.axis = reader.get<std::uint8_t>();
    bool in_order = true;
    std::uint32_t last = 0;
    for (std::size_t slab = 1; slab < slabs; ++slab) {
      cuts.begins.push_back(reader.get<std::uint16_t>());
      in_order = in_order && cuts.begins.back() > last;
      last = cuts.begins.back();
    }
    const RasterLevel& level = state_.slabs.front();
    if (!reader.ok() || (cuts.axis != 1 && cuts.axis != 2) || !in_order ||
        last >= 1u << level.level) {
      return fail("chunk's slabs are out of range");
    }
    if (budget != nullptr) {
      TRY(budget->take(slabs, LevelWalk::kHugePlanes + state_.leaves.size() * sizeof(Leaf)));
    }
    state_.slabs = split(level, cuts);
    state_.slab_leaves.assign(slabs, state_.leaves);
  }
  std::vector<std::size_t> sizes;
  for (std::size_t slab = 1; slab < slabs; ++slab) sizes.push_back(reader.get<std::uint32_t>());
  if (!reader.ok()) return fail("chunk's slabs are cut short");
  ByteView streams = reader.rest();
  std::vector<RangeDecoder> decoders;
  for (const std::size_t size : sizes) {
    if (size > streams.size()) return fail("chunk's slabs are cut short");
    decoders.emplace_back(streams.first(size));
    streams = streams.subspan(size);
  }
  decoders.emplace_back(streams);
  return decoders;
}

Result<void> ContextDecoder::decode_layer(ByteView payload, int first_level, int last_level,
                                          std::size_t mask_count, std::size_t most_nodes,
                                          Bytes& masks, const Executor& executor,
                                          MemoryBudget* budget) {
  const std::size_t levels = static_cast<std::size_t>(last_level - first_level);
  if (payload.size() < levels) return fail("chunk's level classes are cut short");
  const ByteView classes = payload.first(levels);
  for (const std::uint8_t level_class : classes) {
    if (level_class >= kLevelClasses) {
      return fail(concat("chunk has unknown level class ", level_class));
    }
  }
  const auto descend = [&] {
    state_.descend(ByteView(masks).last(nodes_), executor);
    nodes_ = children_;
  };
  if (first_level > 0) descend();
  ByteReader reader(payload.subspan(levels));
  std::vector<RangeDecoder> decoders = TRY(read_slabs(reader, mask_count, budget));
  std::size_t left = mask_count;
  for (int level = first_level; level < last_level; ++level) {
    if (level > first_level) descend();
    if (nodes_ > left) return fail("level sizes disagree with the masks");
    left -= nodes_;
    const int level_class = classes[static_cast<std::size_t>(level - first_level)];
    std::vector<std::size_t> children(state_.slabs.size());
    state_.begin_level(level_class, nodes_);
    code_level(
        state_, level_class, executor,
        [&](std::size_t slab, std::vector<Leaf>& leaves, LevelWalk& walk, std::size_t count) {
#if defined(__x86_64__)
          if (state_.hardware) {
            children[slab] += decode_nodes_bmi2(*state_.tables, level_class, leaves,
                                                state_.slabs[slab], walk, count, decoders[slab]);
            return;
          }
#endif
          children[slab] += decode_nodes<PortableExtract>(
              *state_.tables, level_class, leaves, state_.slabs[slab], walk, count, decoders[slab]);
        });
    children_ = std::accumulate(children.begin(), children.end(), std::size_t{0});
    if (children_ > most_nodes) return fail("more nodes than the header has points");
    const std::size_t begin = masks.size();
    masks.resize(begin + nodes_);
    for_each(executor, static_cast<int>(state_.slabs.size()), [&](int slab) {
      take_masks(state_.slabs[static_cast<std::size_t>(slab)], std::span(masks).subspan(begin));
    });
  }
  if (left != 0) return fail("level sizes disagree with the masks");
  const auto complete = [](const RangeDecoder& decoder) { return decoder.complete(); };
  if (!std::all_of(decoders.begin(), decoders.end(), complete)) {
    return fail("chunk's range-coded data are damaged");
  }
  return {};
}

}  // namespace pointreel
