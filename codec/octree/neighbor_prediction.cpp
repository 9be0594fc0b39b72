#include "codec/octree/neighbor_prediction.h"

#include <bit>
#include <cstring>

namespace pointreel {
namespace {

constexpr std::size_t kPlaces = 19;

/// The step from a cell to its neighbour at a place. Places are the cell itself, its faces, and its
/// edges.
struct Step {
  int x = 0, y = 0, z = 0;
  constexpr int cells() const { return x + 4 * y + 16 * z; }
};

constexpr std::array<Step, kPlaces> make_steps() {
  std::array<Step, kPlaces> steps{};
  std::size_t count = 0;
  for (int away = 0; away <= 2; ++away) {
    for (int at = 0; at < 27; ++at) {
      const Step step{at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1};
      if ((step.x != 0) + (step.y != 0) + (step.z != 0) == away) steps[count++] = step;
    }
  }
  return steps;
}

constexpr std::array<Step, kPlaces> kSteps = make_steps();

/// One octant, or two along x, of the node at a place around another node, which they touch.
/// `cell`: the index of the first among the 4 x 4 x 4 cells around the other node.
struct Run {
  std::uint8_t place, octant, length, cell;
};

constexpr std::size_t kRuns = 40;

constexpr std::array<Run, kRuns> make_runs() {
  std::array<Run, kRuns> runs{};
  std::size_t count = 0;
  for (std::size_t place = 0; place < kPlaces; ++place) {
    const Step& step = kSteps[place];
    for (int octant = 0; octant < 8; ++octant) {
      const int x = 1 + 2 * step.x + (octant & 1), y = 1 + 2 * step.y + (octant >> 1 & 1),
                z = 1 + 2 * step.z + (octant >> 2);
      if (x < 0 || x > 3 || y < 0 || y > 3 || z < 0 || z > 3) continue;
      if (step.x == 0 && (octant & 1) != 0) {
        ++runs[count - 1].length;
      } else {
        runs[count++] = {static_cast<std::uint8_t>(place), static_cast<std::uint8_t>(octant), 1,
                         static_cast<std::uint8_t>(x + 4 * y + 16 * z)};
      }
    }
  }
  return runs;
}

constexpr std::array<Run, kRuns> kRunsAround = make_runs();
static_assert(kRunsAround.back().place == kPlaces - 1);

}  // namespace

Neighborhoods::Neighborhoods(const Svo& svo) : svo_(&svo), around_(svo.node_count(0)) {
  for (Around& around : around_) around = {1};
}

/// A group for each node of the current level; get(child) is what it holds of a child.
template <class T, class Get>
std::vector<Neighborhoods::Group<T>> Neighborhoods::groups(Get get) const {
  const std::size_t begin = svo_->level_begin[static_cast<std::size_t>(level_)];
  std::vector<Group<T>> groups(around_.size() + 1);
  for (std::size_t i = 0; i < around_.size(); ++i) {
    std::uint32_t child = svo_->first_child[begin + i];
    for (unsigned mask = svo_->masks[begin + i]; mask != 0; mask &= mask - 1, ++child) {
      groups[i + 1][static_cast<std::size_t>(std::countr_zero(mask))] = get(child);
    }
  }
  return groups;
}

/// Fills the 56 cells that touch a node's octants across faces and edges, including its own. It
/// does so without branches, which would be unpredictable.
template <class T, std::size_t... kRun>
void Neighborhoods::gather(const Around& around, const std::vector<Group<T>>& groups, T* cells,
                           std::index_sequence<kRun...>) {
  (std::memcpy(cells + kRunsAround[kRun].cell,
               groups[around[kRunsAround[kRun].place]].data() + kRunsAround[kRun].octant,
               kRunsAround[kRun].length * sizeof(T)),
   ...);
}

void Neighborhoods::descend() {
  const std::size_t l = static_cast<std::size_t>(level_);
  const std::size_t begin = svo_->level_begin[l], below = svo_->level_begin[l + 1];
  const auto children = groups<std::uint32_t>(
      [&](std::uint32_t child) { return child - static_cast<std::uint32_t>(below) + 1; });
  std::vector<Around> around_below(svo_->node_count(level_ + 1));
  Around* child = around_below.data();
  std::array<std::uint32_t, 64> cells{};
  for (std::size_t i = 0; i < around_.size(); ++i) {
    gather(around_[i], children, cells.data(), std::make_index_sequence<kRuns>());
    for (unsigned mask = svo_->masks[begin + i]; mask != 0; mask &= mask - 1, ++child) {
      const int middle = ValueBlock::cell(std::countr_zero(mask));
      for (std::size_t place = 0; place < kPlaces; ++place) {
        (*child)[place] = cells[static_cast<std::size_t>(middle + kSteps[place].cells())];
      }
    }
  }
  around_.swap(around_below);
  ++level_;
}

void Neighborhoods::set_values(const Short4* values) {
  values_ = groups<Short4>([&](std::uint32_t child) { return values[child]; });
}

void Neighborhoods::load(std::uint32_t node, ValueBlock& block) const {
  gather(around_[group_of(node) - 1], values_, block.values.data(),
         std::make_index_sequence<kRuns>());
}

}  // namespace pointreel
