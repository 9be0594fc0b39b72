#pragma once

#include <memory>
#include <shared_mutex>
#include <string>
#include <string_view>

#include "server/serve/resource.h"

namespace pointreel {

/// Resources that come and go while the server runs: what live streams have for viewers over HTTP.
/// From any thread. Who is being answered keeps what it was given.
class LiveResources {
 public:
  /// In the place of what was under the path, if anything was.
  void put(const std::string& path, Resource resource);
  void remove(const std::string& path);
  /// Null if there is nothing.
  std::shared_ptr<const Resource> find(std::string_view path) const;

 private:
  mutable std::shared_mutex mutex_;
  ResourceTable resources_;
};

}  // namespace pointreel
