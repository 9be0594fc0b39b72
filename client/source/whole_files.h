#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/http/http_client.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// Fetches ranges of files from any web server. Once one has answered with a whole file, files are
/// fetched whole, and the newest are kept. Any thread may call it.
///
/// Trust: as for HttpClient. The files that are kept take at most kMostBytes.
class WholeFiles {
 public:
  /// Larger files are not fetched whole.
  static constexpr std::uint64_t kMostBytes = std::uint64_t{512} << 20;

  /// `client` outlives this. `say`, if given, gets a line when files begin to be fetched whole.
  WholeFiles(HttpClient& client, std::function<void(const std::string&)> say)
      : client_(client), say_(std::move(say)) {}

  /// As HttpClient::get_ranges.
  Result<std::vector<Bytes>> get_ranges(std::span<const HttpClient::Range> ranges,
                                        const std::stop_token& stop, bool fresh = false);

 private:
  struct File {
    const std::string url;
    const std::uint64_t size;
    std::mutex mutex = {};  ///< held while it is fetched; guards what follows
    Bytes bytes = {};
  };
  Result<Bytes> part_of_file(const HttpClient::Range& range, const std::stop_token& stop,
                             bool fresh);
  std::shared_ptr<File> file_of(const HttpClient::Range& range);

  HttpClient& client_;
  const std::function<void(const std::string&)> say_;
  std::atomic<bool> no_ranges_ = false;
  std::mutex mutex_;                        // guards what follows
  std::list<std::shared_ptr<File>> files_;  ///< the one used last is the first
};

}  // namespace pointreel
