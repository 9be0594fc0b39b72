#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>

#include "server/service/peer.h"

namespace pointreel {

/// Limits how much of something peers may hold, in all and from each address. Any thread may call
/// anything, but each Share only one thread at a time.
class PeerQuota {
 public:
  PeerQuota(std::size_t most, std::size_t most_per_address)
      : most_(most), most_per_address_(most_per_address) {}
  PeerQuota(const PeerQuota&) = delete;
  PeerQuota& operator=(const PeerQuota&) = delete;

  /// What one connection holds, until it is destroyed. The quota must outlive it.
  class Share {
   public:
    Share() = default;
    Share(PeerQuota& quota, const Peer& peer) : quota_(&quota), network_(peer.network) {}
    Share(Share&& other) noexcept
        : quota_(other.quota_), network_(other.network_), held_(std::exchange(other.held_, 0)) {}
    Share& operator=(Share&& other) noexcept {
      std::swap(quota_, other.quota_);
      std::swap(network_, other.network_);
      std::swap(held_, other.held_);
      return *this;
    }
    ~Share() { clear(); }

    /// Takes more. False, and takes nothing, if that were too much.
    bool grow(std::size_t amount);
    /// Gives everything back.
    void clear();

   private:
    PeerQuota* quota_ = nullptr;
    std::array<std::uint8_t, 16> network_{};
    std::size_t held_ = 0;
  };

  /// How much all peers hold together.
  std::size_t held() const {
    const std::lock_guard lock(mutex_);
    return held_;
  }

 private:
  const std::size_t most_, most_per_address_;
  mutable std::mutex mutex_;  // guards what follows
  std::size_t held_ = 0;
  std::map<std::array<std::uint8_t, 16>, std::size_t> per_network_;
};

}  // namespace pointreel
