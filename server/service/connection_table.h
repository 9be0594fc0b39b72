#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>

#include "pointreel/error.h"
#include "server/service/peer.h"

namespace pointreel {

/// Knows all connections, and decides whether there is room for another one. Any thread may call
/// anything.
class ConnectionTable {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Refusal { kFull, kAddress };

  /// The place of a connection, until it is destroyed. The table must outlive it.
  class Place {
   public:
    Place(Place&& other) noexcept
        : table_(std::exchange(other.table_, nullptr)), entry_(other.entry_) {}
    Place& operator=(Place&&) = delete;
    ~Place() {
      if (table_ != nullptr) table_->leave(entry_);
    }
    /// The connection has been waiting for a request since then, and may be closed to make room.
    /// Before the first call, and after `busy`, it may not.
    void idle(Clock::time_point since) { entry_->idle_since = since.time_since_epoch().count(); }
    void busy() { entry_->idle_since = 0; }

   private:
    friend class ConnectionTable;
    struct Entry {
      std::array<std::uint8_t, 16> network;
      std::function<void()> close;
      std::atomic<Clock::rep> idle_since{0};  ///< 0: busy
      bool evicted = false;                   ///< is being closed and no longer counted
    };
    Place(ConnectionTable& table, std::list<Entry>::iterator entry)
        : table_(&table), entry_(entry) {}

    ConnectionTable* table_;
    std::list<Entry>::iterator entry_;
  };

  ConnectionTable(std::size_t most, std::size_t most_per_address)
      : most_(most), most_per_address_(most_per_address) {}
  ConnectionTable(const ConnectionTable&) = delete;
  ConnectionTable& operator=(const ConnectionTable&) = delete;

  /// Gives the connection a place. If there is no room, closes the connection that has waited
  /// longest for a request; if the peer's address has too many connections, one of these. `close`
  /// must end the connection soon. It may be called from any thread, while the table is locked.
  tl::expected<Place, Refusal> admit(const Peer& peer, std::function<void()> close);

  std::size_t count() const { return count_; }
  std::size_t evicted() const { return evictions_; }

 private:
  void leave(std::list<Place::Entry>::iterator entry);
  void forget(Place::Entry& entry);
  bool evict(const std::array<std::uint8_t, 16>* network);

  std::size_t most_, most_per_address_;
  std::mutex mutex_;
  std::list<Place::Entry> entries_;
  std::map<std::array<std::uint8_t, 16>, std::size_t> per_network_;
  std::atomic<std::size_t> count_{0}, evictions_{0};
};

}  // namespace pointreel
