#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "tests/scripted_http_server.h"

namespace pointreel {

/// An object store in memory, which does not look at signatures.
class FakeStore {
 public:
  /// Answers a request instead of the store, and returns true; or returns false.
  using Instead = std::function<bool(int socket, const std::string& head)>;
  explicit FakeStore(Instead instead = {})
      : instead_(std::move(instead)), server_([this](int socket, const std::string& request) {
          return handle(socket, request);
        }) {}

  std::string url() const { return server_.url(); }

  struct Object {
    std::string head, body;  ///< the head of the request that stored it
  };
  std::map<std::string, Object> objects() const {
    const std::lock_guard lock(mutex_);
    return objects_;
  }
  /// "METHOD /path" of each request, in their order.
  std::vector<std::string> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }
  void forget_requests() {
    const std::lock_guard lock(mutex_);
    requests_.clear();
  }
  void remove(const std::string& path) {
    const std::lock_guard lock(mutex_);
    objects_.erase(path);
  }

 private:
  bool handle(int socket, const std::string& request) {
    const std::string head = request.substr(0, request.find("\r\n\r\n"));
    const std::string method = head.substr(0, head.find(' '));
    const std::size_t at = method.size() + 1;
    const std::string path = head.substr(at, head.find(' ', at) - at);
    const std::lock_guard lock(mutex_);
    requests_.push_back(method + " " + path);
    if (instead_ && instead_(socket, head)) return true;
    if (method == "PUT") {
      objects_[path] = {head, request.substr(std::min(request.size(), head.size() + 4))};
      answer(socket, "200 OK", "", "");
      return true;
    }
    const auto object = objects_.find(path);
    if (object == objects_.end()) {
      answer(socket, "404 Not Found", "",
             method == "HEAD" ? "" : "<Error><Code>NoSuchKey</Code></Error>");
      return true;
    }
    std::string headers;
    const std::string& stored = object->second.head;
    if (const auto meta = stored.find("\r\nx-amz-meta-xxh3:"); meta != std::string::npos)
      headers = stored.substr(meta + 2, stored.find("\r\n", meta + 2) - meta - 2) + "\r\n";
    if (method == "HEAD")
      send_text(socket, fmt::format("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n{}\r\n",
                                    object->second.body.size(), headers));
    else
      answer(socket, "200 OK", headers, object->second.body);
    return true;
  }

  const Instead instead_;
  mutable std::mutex mutex_;
  std::map<std::string, Object> objects_;
  std::vector<std::string> requests_;
  ScriptedHttpServer server_;
};

}  // namespace pointreel
