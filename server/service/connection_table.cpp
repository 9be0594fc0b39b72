#include "server/service/connection_table.h"

#include <utility>

namespace pointreel {

tl::expected<ConnectionTable::Place, ConnectionTable::Refusal> ConnectionTable::admit(
    const Peer& peer, std::function<void()> close) {
  const std::lock_guard lock(mutex_);
  const auto of_network = per_network_.find(peer.network);
  if (of_network != per_network_.end() && of_network->second >= most_per_address_ &&
      !evict(&peer.network)) {
    return tl::unexpected(Refusal::kAddress);
  }
  if (count_ >= most_ && !evict(nullptr)) return tl::unexpected(Refusal::kFull);
  Place::Entry& entry = entries_.emplace_back();
  entry.network = peer.network;
  entry.close = std::move(close);
  ++per_network_[peer.network];
  ++count_;
  return Place(*this, std::prev(entries_.end()));
}

/// Closes the connection that has waited longest, of one network or (null) of all. False if none is
/// idle.
bool ConnectionTable::evict(const std::array<std::uint8_t, 16>* network) {
  Place::Entry* longest = nullptr;
  Clock::rep since = 0;
  for (Place::Entry& entry : entries_) {
    const Clock::rep idle = entry.idle_since;
    if (idle == 0 || entry.evicted || (network != nullptr && entry.network != *network)) continue;
    if (longest == nullptr || idle < since) {
      longest = &entry;
      since = idle;
    }
  }
  if (longest == nullptr) return false;
  longest->evicted = true;
  longest->close();
  forget(*longest);
  ++evictions_;
  return true;
}

void ConnectionTable::forget(Place::Entry& entry) {
  --count_;
  const auto of_network = per_network_.find(entry.network);
  if (--of_network->second == 0) per_network_.erase(of_network);
}

void ConnectionTable::leave(std::list<Place::Entry>::iterator entry) {
  const std::lock_guard lock(mutex_);
  if (!entry->evicted) forget(*entry);
  entries_.erase(entry);
}

}  // namespace pointreel
