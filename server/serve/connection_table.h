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
#include "server/serve/peer.h"

namespace pointreel {

/// Who is connected, and whom there is room for. Any thread may call anything.
class ConnectionTable {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Refusal { kFull, kAddress };

  /// A connection's, until it is destroyed. The table must outlive it.
  class Place {
   public:
    Place(Place&& other) noexcept
        : table_(std::exchange(other.table_, nullptr)), entry_(other.entry_) {}
    Place& operator=(Place&&) = delete;
    ~Place() {
      if (table_ != nullptr) table_->leave(entry_);
    }
    /// It waits for a request since then, and may have to go for another connection's sake; it
    /// does not wait before it is told so, and once it is busy.
    void idle(Clock::time_point since) { entry_->idle_since = since.time_since_epoch().count(); }
    void busy() { entry_->idle_since = 0; }

   private:
    friend class ConnectionTable;
    struct Entry {
      std::array<std::uint8_t, 16> network;
      std::function<void()> close;
      std::atomic<Clock::rep> idle_since{0};  ///< 0: busy
      bool evicted = false;                   ///< does not count any more
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

  /// Where there is no room left the connection goes that has waited longest for a request: of
  /// this peer, if it is the peer that has enough. `close` ends this connection, soon, if it must
  /// be so; it is called while others wait, from any thread.
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
