#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "client/source/source.h"
#include "common/base/bytes.h"
#include "common/base/error.h"

namespace pointreel {

/// GET requests over connections that are kept alive, one for each thread that asks at the same
/// time. Trusts no server: bodies are bounded while they arrive, and status and Content-Range must
/// be what was asked for. Failures that may pass are tried again, after a pause that doubles.
/// Errors do not repeat the URL.
class HttpClient {
 public:
  explicit HttpClient(const SourceOptions& options);
  ~HttpClient();

  /// The whole of `url`, at most `max_bytes`.
  Result<Bytes> get(const std::string& url, std::uint64_t max_bytes);
  /// `size` >= 1 bytes from `offset` on of a file that has `total` bytes.
  Result<Bytes> get_range(const std::string& url, std::uint64_t offset, std::uint64_t size,
                          std::uint64_t total);

  /// Makes all requests, now and later, fail within about a second.
  void cancel();

 private:
  struct Connection;
  struct Wanted;
  struct Answer;

  Result<Bytes> get_with_retries(const std::string& url, const Wanted& wanted);
  Answer attempt(Connection& connection, const std::string& url, const Wanted& wanted) const;

  const SourceOptions options_;
  std::mutex mutex_;
  std::condition_variable cancelled_changed_;
  std::atomic<bool> cancelled_{false};
  std::vector<std::unique_ptr<Connection>> idle_;
};

}  // namespace pointreel
