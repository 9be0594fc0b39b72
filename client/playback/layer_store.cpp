#include "client/playback/layer_store.h"

#include <algorithm>
#include <utility>

namespace pointreel {

const LayerStore::Record* LayerStore::find(std::uint32_t frame) const {
  const auto it = records_.find(frame);
  return it == records_.end() ? nullptr : &it->second;
}

std::uint32_t LayerStore::clamped(const Record* record, const LayerRange& wanted) const {
  const std::uint32_t most = std::min(wanted.end, layer_count_);
  return record ? std::min(most, record->limit) : most;
}

std::uint32_t LayerStore::usable(std::uint32_t frame, const LayerRange& wanted) const {
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

bool LayerStore::coming(std::uint32_t frame, const LayerRange& wanted) const {
  const Record* record = find(frame);
  if (!record) return false;
  const auto end = record->slots.begin() + clamped(record, wanted);
  return std::any_of(record->slots.begin(), end,
                     [](const Slot& slot) { return slot.state == Slot::State::coming; });
}

FetchedFrame LayerStore::get(std::uint32_t frame, std::uint32_t layers) const {
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

std::optional<FetchRequest> LayerStore::begin(std::uint32_t frame, const LayerRange& wanted) {
  const Record* known = find(frame);
  const std::uint32_t most = clamped(known, wanted);
  const auto missing = [&](std::uint32_t layer) {
    if (!known) return true;
    const Slot& slot = known->slots[layer];
    return slot.state == Slot::State::absent ||
           (slot.state == Slot::State::here && !covers(slot, wanted));
  };
  LayerRange layers = wanted;
  while (layers.first < most && !missing(layers.first)) ++layers.first;
  if (layers.first == most) return std::nullopt;
  layers.end = layers.first + 1;
  while (layers.end < most && missing(layers.end)) ++layers.end;

  Record& record = records_[frame];
  record.slots.resize(layer_count_);
  const std::uint32_t bits = ((1u << layers.end) - 1) & ~((1u << layers.first) - 1);
  Running running;
  running.request = {.frame = frame,
                     .layers = layers,
                     .fresh = (record.refetched & bits) != 0,
                     .stop = running.stop.get_token(),
                     .id = next_id_++};
  for (std::uint32_t i = layers.first; i < layers.end; ++i) {
    drop(record, record.slots[i]);
    record.slots[i].state = Slot::State::coming;
    record.slots[i].request = running.request.id;
  }
  FetchRequest request = running.request;
  running_.emplace(request.id, std::move(running));
  return request;
}

void LayerStore::drop(Record& record, Slot& slot) {
  record.bytes -= slot.layer.bytes.size();
  bytes_ -= slot.layer.bytes.size();
  slot = {};
}

void LayerStore::unmark(const FetchRequest& request) {
  running_.erase(request.id);
  const auto it = records_.find(request.frame);
  if (it == records_.end()) return;
  for (Slot& slot : it->second.slots)
    if (slot.state == Slot::State::coming && slot.request == request.id) slot = {};
}

void LayerStore::arrived(const FetchRequest& request, FetchedFrame came, double ms) {
  unmark(request);
  arrived_bytes_ += came.size();
  ++arrived_requests_;
  Record& record = records_[request.frame];
  record.slots.resize(layer_count_);
  record.fetch_ms = std::max(record.fetch_ms, ms);
  const bool is_file = came.layers.empty();
  for (std::uint32_t i = request.layers.first; i < request.layers.end; ++i) {
    Slot& slot = record.slots[i];
    // The same may have come with a later request already.
    if (slot.state == Slot::State::here && covers(slot, request.layers)) continue;
    drop(record, slot);
    slot.state = Slot::State::here;
    slot.colors = request.layers.colors || is_file;
    slot.normals = request.layers.normals || is_file;
    if (is_file || i - request.layers.first >= came.layers.size()) continue;
    slot.layer = std::move(came.layers[i - request.layers.first]);
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

void LayerStore::failed(const FetchRequest& request) { unmark(request); }

bool LayerStore::give_up(const FetchRequest& request) {
  unmark(request);
  Record& record = records_[request.frame];
  record.slots.resize(layer_count_);
  // If several layers were requested at once, any of them may be at fault: the first is tried
  // alone.
  const bool several = request.layers.end - request.layers.first > 1;
  record.limit = std::min(record.limit, several ? request.layers.first + 1 : request.layers.first);
  return record.limit > 0;
}

void LayerStore::stop(const std::function<bool(std::uint32_t)>& stale) {
  for (auto it = running_.begin(); it != running_.end();) {
    if (!stale(it->second.request.frame)) {
      ++it;
      continue;
    }
    it->second.stop.request_stop();
    const FetchRequest request = it->second.request;
    ++it;
    unmark(request);
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
  return arrived_requests_ == 0 ? 0 : arrived_bytes_ / arrived_requests_ * running_.size();
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
    Record& record = it->second;
    bytes_ -= std::exchange(record.bytes, 0);
    if (record.limit == ~0u && record.refetched == 0) {
      records_.erase(it);  // layers of it that are still coming make a new record
      continue;
    }
    // What could not be had is remembered, or it would be wanted again at once.
    record.file.reset();
    for (Slot& slot : record.slots)
      if (slot.state == Slot::State::here) slot = {};
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
