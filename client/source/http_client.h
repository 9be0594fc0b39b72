#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "client/source/source.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// A package's folder: what its address is, or that of its reel.json, without a slash at the end.
Result<std::string> folder_address(const std::string& url);

/// GET requests, several at a time over connections that are kept alive, made by a thread of its
/// own. A transfer in which no byte moves is given up and made again over a new connection, and
/// failures that may pass are tried again after a pause that doubles; http_transfer.h tells what is
/// believed of a server, and which failures pass. An answer that makes no sense is asked for once
/// more. All functions may be called from any thread. Errors begin with the URL.
class HttpClient {
 public:
  explicit HttpClient(const SourceOptions& options);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  /// The whole of `url`, at most `max_bytes`, after at most `open_attempts` attempts.
  Result<Bytes> get(const std::string& url, std::uint64_t max_bytes);

  /// The same, tried without end; nothing if it is still what had the entity tag `tag`, which
  /// becomes that of what is given.
  Result<std::optional<Bytes>> get_if_changed(const std::string& url, std::uint64_t max_bytes,
                                              std::string& tag, const std::stop_token& stop);

  /// `size` >= 1 bytes from `offset` on of a file that has `total` bytes.
  struct Range {
    std::string url;
    std::uint64_t offset = 0, size = 0, total = 0;
  };
  /// All of them at the same time, tried without end. `fresh`: past caches.
  Result<std::vector<Bytes>> get_ranges(std::span<const Range> ranges, const std::stop_token& stop,
                                        bool fresh = false);

  /// Makes all requests, now and later, fail soon.
  void cancel();

  /// "host:port: what is wrong; trying again", of the newest request that waits for something to
  /// pass; none if none does.
  std::optional<std::string> trouble() const;
  LinkUse link_use() const;

 private:
  class Loop;
  const std::unique_ptr<Loop> loop_;
};

}  // namespace pointreel
