#pragma once

#include <memory>
#include <shared_mutex>
#include <string>
#include <string_view>

#include "server/service/resource.h"

namespace pointreel {

/// Resources that come and go while the server runs, which live streams offer to viewers over HTTP.
/// Any thread may call anything. A resource that is being sent lives until it has been sent.
class LiveResources {
 public:
  /// Replaces the resource at the path, if there is one.
  void put(const std::string& path, Resource resource);
  void remove(const std::string& path);
  /// Null if there is nothing.
  std::shared_ptr<const Resource> find(std::string_view path) const;

 private:
  mutable std::shared_mutex mutex_;
  ResourceTable resources_;
};

}  // namespace pointreel
