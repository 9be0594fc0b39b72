#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/http/aws_access.h"
#include "common/http/http_options.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// Makes GET requests on a thread of its own, several at a time, over connections that are kept
/// alive. A transfer in which no byte moves is given up and made again over a new connection.
/// Failures that may pass are tried again after a pause that doubles, and an answer that makes no
/// sense is asked for once more; http_transfer.h says which answers are trusted, and which failures
/// may pass. All functions may be called from any thread. Errors begin with the URL.
class HttpClient {
 public:
  /// `access`: what to sign all requests with, if anything.
  explicit HttpClient(const HttpOptions& options, std::optional<AwsAccess> access = {});
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  /// The whole file, of at most `max_bytes`. Fails after HttpOptions::open_attempts attempts.
  Result<Bytes> get(const std::string& url, std::uint64_t max_bytes);

  /// The same, but tried without end. Nothing if the file still has the entity tag `tag`; else
  /// `tag` becomes that of the file returned.
  Result<std::optional<Bytes>> get_if_changed(const std::string& url, std::uint64_t max_bytes,
                                              std::string& tag, const std::stop_token& stop);

  /// `size` >= 1 bytes from `offset` on of a file that has `total` bytes.
  struct Range {
    std::string url;
    std::uint64_t offset = 0, size = 0, total = 0;
  };
  /// Fetches all of them at the same time, and tries HttpOptions::fetch_attempts times. `fresh`:
  /// asks caches for new copies. The error is `unsupported` if the server sends whole files
  /// instead.
  Result<std::vector<Bytes>> get_ranges(std::span<const Range> ranges, const std::stop_token& stop,
                                        bool fresh = false);

  /// Makes all requests, now and later, fail soon.
  void cancel();

  /// "host:port: what is wrong; trying again", for the newest of the requests that wait to be tried
  /// again; none if none does.
  std::optional<std::string> trouble() const;
  LinkUse link_use() const;

 private:
  class Loop;
  const std::unique_ptr<Loop> loop_;
};

}  // namespace pointreel
