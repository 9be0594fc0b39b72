#include "codec/octree/context_coder.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

#include "codec/octree/mask_coder.h"
#include "common/base/concat.h"
#include "common/base/for_each.h"
#include "common/base/try.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

constexpr std::size_t kLeavesOfSlab = std::size_t{1} << 19;

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

/// Codes the current level slab by slab.
template <class Coder>
void code_level(ContextState& state, int level_class, std::vector<Coder>& coders,
                const Executor& executor) {
  for_each(executor, static_cast<int>(state.slabs()), [&](int number) {
    const auto slab = static_cast<std::size_t>(number);
    MaskCoder<Coder> coder{*state.tables, state.alphabets[slab], coders[slab], state.hardware};
    coder.code(state.level, level_class, state.first_slice(slab), state.first_slice(slab + 1));
  });
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

/// The z at which slabs of about equal weight begin, without that of the first; fewer than `slabs`
/// if the level has too few slices. `weights`: those of the nodes, in Morton order.
std::vector<std::uint32_t> choose_begins(const SliceLevel& level,
                                         std::span<const std::uint32_t> weights, int slabs) {
  const std::uint64_t total = std::accumulate(weights.begin(), weights.end(), std::uint64_t{0});
  std::vector<std::uint32_t> begins;
  std::uint64_t before = 0;
  for (std::size_t s = 0; s < level.slice_count(); ++s) {
    std::uint64_t weight = 0;
    for (std::uint32_t i = level.slices[s].begin; i < level.slices[s + 1].begin; ++i) {
      weight += weights[level.rank[i]];
    }
    // A slab begins with the first slice whose middle reaches its share of the weights, which
    // divides them best.
    const std::uint64_t number = begins.size() + 1;
    const bool reached = 2 * before + weight >= 2 * total * number / static_cast<unsigned>(slabs);
    if (s > 0 && number < static_cast<unsigned>(slabs) && reached) {
      begins.push_back(level.slices[s].z);
    }
    before += weight;
  }
  return begins;
}

}  // namespace

int default_slabs(std::size_t leaves) {
  const std::size_t slabs = leaves / kLeavesOfSlab;
  return static_cast<int>(std::clamp(slabs, std::size_t{1}, std::size_t{kMostSlabs}));
}

// --- State ---

ContextState::ContextState(std::shared_ptr<const ContextTables> from)
    : tables(std::move(from)),
      level(root_level()),
      alphabets{tables->alphabets},
      hardware((cpu_features() & kCpuBmi2) != 0) {}

void ContextState::descend(ByteView masks) {
  std::vector<std::uint32_t> first_child;
  const std::size_t children = number_children(masks, first_child);
  SliceLevel below;
  expand(level, first_child, children, below);
  level = std::move(below);
  for (std::uint32_t& begin : slab_begins) begin *= 2;
}

void ContextState::divide(std::vector<std::uint32_t> begins) {
  alphabets.resize(begins.size() + 1, alphabets.front());
  slab_begins = std::move(begins);
}

std::size_t ContextState::first_slice(std::size_t slab) const {
  if (slab == 0) return 0;
  return slab < slabs() ? slice_from(level, slab_begins[slab - 1]) : level.slice_count();
}

// --- Encoder ---

ContextEncoder::ContextEncoder(std::shared_ptr<const ContextTables> tables, int slabs)
    : state_(std::move(tables)), wanted_slabs_(slabs) {}

void ContextEncoder::write_slabs(const Svo& svo, int first_level, std::size_t mask_count,
                                 Bytes& payload) {
  ByteWriter writer(payload);
  const int most = static_cast<int>(
      std::min(mask_count / kLeastMasksOfSlab, static_cast<std::size_t>(wanted_slabs_)));
  const bool whole = state_.slabs() == 1;
  if (whole && first_level > 0 && most > 1) {
    state_.divide(choose_begins(state_.level, weights_of_nodes(svo, first_level), most));
  }
  writer.put(static_cast<std::uint8_t>(state_.slabs()));
  if (!whole) return;
  for (const std::uint32_t begin : state_.slab_begins) {
    writer.put(static_cast<std::uint16_t>(begin));
  }
}

void ContextEncoder::encode_layer(const Svo& svo, int first_level, int last_level, Bytes& payload,
                                  const Executor& executor) {
  const auto class_of = [&svo](int level) {
    return level_class(level, svo.node_count(level), svo.node_count(level + 1));
  };
  const auto masks_of = [&svo](int level) {
    return ByteView(svo.masks).subspan(svo.level_begin[static_cast<std::size_t>(level)],
                                       svo.node_count(level));
  };
  for (int level = first_level; level < last_level; ++level) {
    payload.push_back(static_cast<std::uint8_t>(class_of(level)));
  }
  if (first_level > 0) state_.descend(masks_of(first_level - 1));
  write_slabs(svo, first_level,
              svo.level_begin[static_cast<std::size_t>(last_level)] -
                  svo.level_begin[static_cast<std::size_t>(first_level)],
              payload);
  std::vector<SymbolEncoder> encoders(state_.slabs());
  for (int level = first_level; level < last_level; ++level) {
    if (level > first_level) state_.descend(masks_of(level - 1));
    const ByteView masks = masks_of(level);
    for (std::size_t i = 0; i < masks.size(); ++i) {
      state_.level.masks[i] = masks[state_.level.rank[i]];
    }
    code_level(state_, class_of(level), encoders, executor);
  }
  std::vector<Bytes> streams(encoders.size());
  for_each(executor, static_cast<int>(streams.size()), [&](int slab) {
    encoders[static_cast<std::size_t>(slab)].finish(streams[static_cast<std::size_t>(slab)]);
  });
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

Result<std::vector<SymbolDecoder>> ContextDecoder::read_slabs(ByteReader& reader,
                                                              std::size_t mask_count,
                                                              MemoryBudget* budget) {
  const std::size_t slabs = reader.get<std::uint8_t>();
  if (slabs != state_.slabs()) {
    if (state_.slabs() > 1 || slabs == 0 || slabs > kMostSlabs ||
        slabs * kLeastMasksOfSlab > mask_count) {
      return fail(concat("chunk cannot have ", slabs, " slabs"));
    }
    std::vector<std::uint32_t> begins;
    bool in_order = true;
    std::uint32_t last = 0;
    for (std::size_t slab = 1; slab < slabs; ++slab) {
      begins.push_back(reader.get<std::uint16_t>());
      in_order = in_order && begins.back() > last;
      last = begins.back();
    }
    if (!reader.ok() || !in_order || last >= 1u << state_.level.level) {
      return fail("chunk's slabs are out of range");
    }
    if (budget != nullptr) {
      TRY(budget->take(
          slabs, SparseWalk::kHugePlanes + state_.tables->alphabets.size() * sizeof(Alphabet16)));
    }
    state_.divide(std::move(begins));
  }
  std::vector<std::size_t> sizes;
  for (std::size_t slab = 1; slab < slabs; ++slab) sizes.push_back(reader.get<std::uint32_t>());
  if (!reader.ok()) return fail("chunk's slabs are cut short");
  ByteView streams = reader.rest();
  std::vector<SymbolDecoder> decoders;
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
    state_.descend(ByteView(masks).last(nodes_));
    nodes_ = children_;
  };
  if (first_level > 0) descend();
  ByteReader reader(payload.subspan(levels));
  std::vector<SymbolDecoder> decoders = TRY(read_slabs(reader, mask_count, budget));
  std::size_t left = mask_count;
  for (int level = first_level; level < last_level; ++level) {
    if (level > first_level) descend();
    if (nodes_ > left) return fail("level sizes disagree with the masks");
    left -= nodes_;
    const int level_class = classes[static_cast<std::size_t>(level - first_level)];
    if (level_class >= kFirstCausalClass && !may_be_causal(level, nodes_)) {
      return fail("chunk has a level whose class needs more nodes");
    }
    code_level(state_, level_class, decoders, executor);
    const std::size_t begin = masks.size();
    masks.resize(begin + nodes_);
    children_ = 0;
    bool empty = false;
    for (std::size_t i = 0; i < nodes_; ++i) {
      const std::uint8_t mask = state_.level.masks[i];
      masks[begin + state_.level.rank[i]] = mask;
      children_ += static_cast<unsigned>(std::popcount(mask));
      empty = empty || mask == 0;
    }
    if (empty) return fail("chunk has a node without children");
    if (children_ > most_nodes) return fail("more nodes than the header has points");
  }
  if (left != 0) return fail("level sizes disagree with the masks");
  const auto complete = [](const SymbolDecoder& d) { return d.complete_but_for_zeros(); };
  if (!std::all_of(decoders.begin(), decoders.end(), complete)) {
    return fail("chunk's coded masks are damaged");
  }
  return {};
}

}  // namespace pointreel
