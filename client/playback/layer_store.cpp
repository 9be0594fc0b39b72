#include "client/playback/layer_store.h"

#include <algorithm>
#include <utility>

namespace pointreel {

const LayerStore::Record* LayerStore::find(std::uint32_t frame) const {
  const auto it = records_.find(frame);
  return it == records_.end() ? nullptr : &it->second;
}

std::uint32_t LayerStore::clamped(const Record* record, const LayerSet& wanted) const {
  const std::uint32_t most = std::min(wanted.layers, layer_count_);
  return record ? std::min(most, record->limit) : most;
}

std::uint32_t LayerStore::usable(std::uint32_t frame, const LayerSet& wanted) const {
  const Record* record = find(frame);
  if (!record) return 0;
  const std::uint32_t most = clamped(record, wanted);
  std::uint32_t layers = 0;
  while (layers < most && record->slots[layers].state == Slot::State::here &&
         covers(record->slots[layers], wanted))
    ++layers;
  return layers;
}

void LayerStore::for_each(
    const std::function<void(std::uint32_t frame, std::uint32_t layers)>& tell) const {
  for (const auto& [frame, record] : records_) {
    std::uint32_t layers = 0;
    while (layers < record.slots.size() && record.slots[layers].state == Slot::State::here)
      ++layers;
    if (layers > 0) tell(frame, layers);
  }
}

bool LayerStore::coming(std::uint32_t frame, const LayerSet& wanted) const {
  const Record* record = find(frame);
  if (!record) return false;
  const auto end = record->slots.begin() + clamped(record, wanted);
  return std::any_of(record->slots.begin(), end,
                     [](const Slot& slot) { return slot.state == Slot::State::coming; });
}

FetchedFrame LayerStore::copy(std::uint32_t frame, std::uint32_t layers) const {
  const Record& record = records_.at(frame);
  if (record.file) return *record.file;
  FetchedFrame fetched;
  fetched.tables = record.tables;
  for (std::uint32_t i = 0; i < layers; ++i) fetched.layers.push_back(record.slots[i].layer);
  return fetched;
}

double LayerStore::fetch_ms(std::uint32_t frame) const {
  const Record* record = find(frame);
  return record == nullptr ? 0.0 : record->fetch_ms;
}

double LayerStore::take_fetch_ms(std::uint32_t frame) {
  const auto it = records_.find(frame);
  return it == records_.end() ? 0.0 : std::exchange(it->second.fetch_ms, 0.0);
}

std::uint32_t LayerStore::limit(std::uint32_t frame) const {
  const Record* record = find(frame);
  return record ? record->limit : ~0u;
}

std::optional<FetchJob> LayerStore::begin(std::uint32_t frame, const LayerSet& wanted) {
  const Record* known = find(frame);
  const std::uint32_t most = clamped(known, wanted);
  const auto missing = [&](std::uint32_t layer) {
    if (!known) return true;
    const Slot& slot = known->slots[layer];
    return slot.state == Slot::State::absent ||
           (slot.state == Slot::State::here && !covers(slot, wanted));
  };
  std::uint32_t first = 0;
  while (first < most && !missing(first)) ++first;
  if (first == most) return std::nullopt;
  std::uint32_t last = first + 1;
  while (last < most && missing(last)) ++last;

  Record& record = records_[frame];
  record.slots.resize(layer_count_);
  Running running;
  const std::uint32_t layers = ((1u << last) - 1) & ~((1u << first) - 1);
  running.job = {next_id_++,
                 frame,
                 first,
                 last,
                 wanted.colors,
                 wanted.normals,
                 (record.refetched & layers) != 0,
                 running.stop.get_token()};
  for (std::uint32_t i = first; i < last; ++i) {
    drop(record, record.slots[i]);
    record.slots[i].state = Slot::State::coming;
    record.slots[i].job = running.job.id;
  }
  FetchJob job = running.job;
  running_.emplace(job.id, std::move(running));
  return job;
}

void LayerStore::drop(Record& record, Slot& slot) {
  record.bytes -= slot.layer.bytes.size();
  bytes_ -= slot.layer.bytes.size();
  slot = {};
}

void LayerStore::unmark(const FetchJob& job) {
  running_.erase(job.id);
  const auto it = records_.find(job.frame);
  if (it == records_.end()) return;
  for (Slot& slot : it->second.slots)
    if (slot.state == Slot::State::coming && slot.job == job.id) slot = {};
}

void LayerStore::arrived(const FetchJob& job, FetchedFrame came, double ms) {
  unmark(job);
  arrived_bytes_ += came.size();
  ++arrived_jobs_;
  Record& record = records_[job.frame];
  record.slots.resize(layer_count_);
  record.fetch_ms = std::max(record.fetch_ms, ms);
  const bool is_file = came.layers.empty();
  for (std::uint32_t i = job.first; i < job.last; ++i) {
    Slot& slot = record.slots[i];
    // The same may have come with a later job already.
    if (slot.state == Slot::State::here && covers(slot, {1, job.colors, job.normals})) continue;
    drop(record, slot);
    slot.state = Slot::State::here;
    slot.colors = job.colors || is_file;
    slot.normals = job.normals || is_file;
    if (is_file || i - job.first >= came.layers.size()) continue;
    slot.layer = std::move(came.layers[i - job.first]);
    record.bytes += slot.layer.bytes.size();
    bytes_ += slot.layer.bytes.size();
  }
  record.tables = came.tables;
  if (!is_file) return;
  if (record.file) {
    record.bytes -= record.file->file.size();
    bytes_ -= record.file->file.size();
  }
  record.bytes += came.file.size();
  bytes_ += came.file.size();
  record.file = std::move(came);
}

void LayerStore::failed(const FetchJob& job) { unmark(job); }

bool LayerStore::give_up(const FetchJob& job) {
  unmark(job);
  Record& record = records_[job.frame];
  record.slots.resize(layer_count_);
  // Of several layers that were asked for at once any may be at fault: the first is tried alone.
  const bool several = job.last - job.first > 1;
  record.limit = std::min(record.limit, several ? job.first + 1 : job.first);
  return record.limit > 0;
}

void LayerStore::stop(const std::function<bool(std::uint32_t)>& stale) {
  for (auto it = running_.begin(); it != running_.end();) {
    if (!stale(it->second.job.frame)) {
      ++it;
      continue;
    }
    it->second.stop.request_stop();
    const FetchJob job = it->second.job;
    ++it;
    unmark(job);
  }
}

bool LayerStore::broken(std::uint32_t frame, std::uint32_t layer) {
  const auto it = records_.find(frame);
  if (it == records_.end() || layer >= layer_count_) return false;
  Record& record = it->second;
  if (record.slots[layer].state != Slot::State::here) return true;  // it is coming again already
  if (record.file) {
    record.bytes -= record.file->file.size();
    bytes_ -= record.file->file.size();
    record.file.reset();
  }
  drop(record, record.slots[layer]);
  const std::uint32_t bit = 1u << layer;
  if ((record.refetched & bit) != 0) {
    record.limit = std::min(record.limit, layer);
    return false;
  }
  record.refetched |= bit;
  return true;
}

std::uint64_t LayerStore::coming_bytes() const {
  return arrived_jobs_ == 0 ? 0 : arrived_bytes_ / arrived_jobs_ * running_.size();
}

void LayerStore::shrink(std::uint64_t budget,
                        const std::function<std::uint64_t(std::uint32_t)>& rank) {
  if (bytes_ <= budget) return;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> ranked;
  for (const auto& [frame, record] : records_)
    if (const std::uint64_t value = rank(frame); value > 0) ranked.emplace_back(value, frame);
  std::sort(ranked.rbegin(), ranked.rend());
  for (const auto& [value, frame] : ranked) {
    if (bytes_ <= budget - budget / 16) break;
    const auto it = records_.find(frame);
    bytes_ -= it->second.bytes;
    records_.erase(it);  // what is coming of it finds no slots and makes a new record
  }
}

void LayerStore::forgive(const std::function<bool(std::uint32_t)>& which) {
  for (auto& [frame, record] : records_) {
    if (!which(frame)) continue;
    record.limit = ~0u;
    record.refetched = 0;
  }
}

}  // namespace pointreel
