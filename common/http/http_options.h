#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

namespace pointreel {

/// What a link has carried so far.
struct LinkUse {
  std::uint64_t bytes = 0;  ///< of the bodies of answers
  /// The time in which at least one answer was coming, its first byte here and its last one not.
  /// `bytes` divided by it is the link's rate, however many answers come at once.
  std::chrono::microseconds receiving{0};
  std::chrono::microseconds busy{0};  ///< the time in which at least one request was not answered
  /// The least time lately from a request to the first byte of its answer; 0 if not known.
  std::chrono::microseconds round_trip{0};
};

struct HttpOptions {
  std::string token;              ///< bearer token, sent if not empty; not to object stores
  std::string ca_file;            ///< PEM certificates to trust for https; empty: the system's
  std::string endpoint;           ///< of the object store that s3:// means, as in resolve_store
  bool follow_redirects = false;  ///< also to other hosts; never from https to http
  /// TLS included. For WebSocket it doubles, up to eight times as long, while connecting fails.
  std::chrono::milliseconds connect_timeout{2'000};
  /// How long a connection may bring no byte. Doubles, up to four times as long, while a server
  /// that can be reached stays silent.
  std::chrono::milliseconds stall_timeout{1'500};
  std::chrono::milliseconds first_backoff{100};  ///< wait before trying again; doubles each time
  std::chrono::milliseconds max_backoff{500};
  std::stop_token stop = {};  ///< asked to stop, opening a source fails soon
  /// Called by any thread when HttpClient::trouble has changed, with what it is now; also while a
  /// source is being opened.
  std::function<void(const std::optional<std::string>&)> on_trouble = {};
  int open_attempts = 4;   ///< for a whole file
  int fetch_attempts = 0;  ///< for each range; 0: without end
};

}  // namespace pointreel
