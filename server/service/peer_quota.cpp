#include "server/service/peer_quota.h"

namespace pointreel {

bool PeerQuota::Share::grow(std::size_t amount) {
  const std::lock_guard lock(quota_->mutex_);
  const auto of_network = quota_->per_network_.find(network_);
  const std::size_t before = of_network == quota_->per_network_.end() ? 0 : of_network->second;
  if (amount > quota_->most_ - quota_->held_ || before > quota_->most_per_address_ ||
      amount > quota_->most_per_address_ - before) {
    return false;
  }
  quota_->per_network_[network_] = before + amount;
  quota_->held_ += amount;
  held_ += amount;
  return true;
}

void PeerQuota::Share::clear() {
  if (held_ == 0) return;
  const std::lock_guard lock(quota_->mutex_);
  const auto of_network = quota_->per_network_.find(network_);
  if ((of_network->second -= held_) == 0) quota_->per_network_.erase(of_network);
  quota_->held_ -= held_;
  held_ = 0;
}

}  // namespace pointreel
