#include "server/service/live_resources.h"

#include <mutex>
#include <utility>

namespace pointreel {

void LiveResources::put(const std::string& path, Resource resource) {
  auto shared = std::make_shared<const Resource>(std::move(resource));
  const std::lock_guard lock(mutex_);
  resources_[path].swap(shared);  // the old resource is destroyed after the lock is released
}

void LiveResources::remove(const std::string& path) {
  ResourceTable::node_type gone;
  const std::lock_guard lock(mutex_);
  gone = resources_.extract(path);
}

std::shared_ptr<const Resource> LiveResources::find(std::string_view path) const {
  const std::shared_lock lock(mutex_);
  const auto found = resources_.find(path);
  return found == resources_.end() ? nullptr : found->second;
}

}  // namespace pointreel
