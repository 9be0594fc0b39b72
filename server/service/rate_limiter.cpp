#include "server/service/rate_limiter.h"

#include <algorithm>

namespace pointreel {

bool RateLimiter::allow(const Network& network, Clock::time_point now) {
  if (!limits()) return true;
  const auto cost =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate_));
  const std::lock_guard lock(mutex_);
  if (full_at_.size() >= kMost && !full_at_.contains(network)) {
    if (now >= next_look_) {
      std::erase_if(full_at_, [now](const auto& each) { return each.second <= now; });
      next_look_ = now + std::chrono::milliseconds(500);
    }
    // With so many addresses at once, requests from further ones are allowed without being counted.
    if (full_at_.size() >= kMost) return true;
  }
  Clock::time_point& full = full_at_.try_emplace(network, now).first->second;
  const Clock::time_point next = std::max(full, now) + cost;
  if (next > now + std::max<Clock::duration>(std::chrono::seconds(1), cost)) return false;
  full = next;
  return true;
}

std::size_t RateLimiter::size() const {
  const std::lock_guard lock(mutex_);
  return full_at_.size();
}

}  // namespace pointreel
