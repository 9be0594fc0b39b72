#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

#include "pointreel/error.h"

namespace pointreel {

/// A number that no handle of any kind has had before.
std::uintptr_t next_handle();

/// What handles of one kind stand for. A handle is a number in the place of an address: one that
/// was closed, or is of another kind, is known not to stand for anything. Safe to use from any
/// thread; what a handle stands for lives until the calls that use it have returned.
template <class Handle, class Object>
class Handles {
 public:
  Handle* add(std::shared_ptr<Object> object) {
    const std::uintptr_t number = next_handle();
    const std::lock_guard lock(mutex_);
    objects_.emplace(number, std::move(object));
    return reinterpret_cast<Handle*>(number);
  }

  /// Null if there is none.
  std::shared_ptr<Object> find(const Handle* handle) const noexcept {
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(reinterpret_cast<std::uintptr_t>(handle));
    return found == objects_.end() ? nullptr : found->second;
  }

  /// `what`: "the reel", for the error.
  Result<std::shared_ptr<Object>> get(const Handle* handle, const char* what) const {
    if (auto object = find(handle)) return object;
    return fail(
        ErrorCode::argument,
        std::string(what) + (handle == nullptr ? " is NULL" : " is closed, or is not a handle"));
  }

  void close(const Handle* handle) noexcept {
    std::shared_ptr<Object> object;  // ends after the lock
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(reinterpret_cast<std::uintptr_t>(handle));
    if (found == objects_.end()) return;
    object = std::move(found->second);
    objects_.erase(found);
  }

 private:
  mutable std::mutex mutex_;
  std::unordered_map<std::uintptr_t, std::shared_ptr<Object>> objects_;
};

}  // namespace pointreel
