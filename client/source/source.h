#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "client/source/fetched.h"
#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// Layers of one frame that somebody waits for.
struct FetchRequest {
  std::uint32_t frame = 0;  ///< below Manifest::frame_count()
  LayerRange layers = {};   ///< files come whole, whatever it says
  bool fresh = false;       ///< asks caches on the way for a new copy: a layer came damaged before
  std::stop_token stop = {};  ///< a fetch that is asked to stop fails soon
  std::uint64_t id = 0;       ///< tells LayerStore its requests apart; sources ignore it
};

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

/// Where frames come from.
class Source {
 public:
  virtual ~Source() = default;

  virtual const Manifest& manifest() const = 0;

  /// May be called by many threads at once. Failures that may pass (no connection, no answer in
  /// time, 5xx) are tried again for as long as they last. An error is a failure that will not pass,
  /// or ErrorCode::cancelled if the fetch was stopped or cancelled. The bytes may be hostile, but
  /// there are as many as `sizes` says.
  virtual Result<FetchedFrame> fetch(const FetchRequest& request) = 0;

  /// Fetches bytes [offset, offset + size) of the manifest's sound, which has them, in the same
  /// way.
  virtual Result<Bytes> fetch_audio(std::uint64_t /*offset*/, std::uint64_t /*size*/,
                                    const std::stop_token& /*stop*/) {
    return fail(ErrorCode::not_found, "has no sound");
  }

  // These may be called from any thread, too.

  /// Makes fetches under way, and all later ones, fail soon.
  virtual void cancel() {}

  /// One line while fetches wait for a failure to pass, as in "host:8090: nothing answers there;
  /// trying again"; none when all is well.
  virtual std::optional<std::string> trouble() const { return std::nullopt; }

  /// All zero where there is no link.
  virtual LinkUse link_use() const { return {}; }
};

struct SourceOptions {
  /// Of folders of files, which do not tell it; 30 if it is not given, and not for recordings.
  std::optional<double> fps = {};
  std::string topic = {};                   ///< of recordings that have several
  Placement placement = {};                 ///< of the points of files
  std::uint64_t max_memory = kFrameMemory;  ///< DecodeLimits::max_memory
  // For HTTP and WebSocket.
  std::string token;    ///< bearer token, sent if not empty
  std::string ca_file;  ///< PEM certificates to trust for https and wss; empty: the system's
  bool follow_redirects = false;  ///< also to other hosts; never from https to http
  /// TLS included. For WebSocket it doubles, up to eight times as long, while connecting fails.
  std::chrono::milliseconds connect_timeout{2'000};
  /// How long a connection may bring no byte. Doubles, up to four times as long, while a server
  /// that can be reached stays silent.
  std::chrono::milliseconds stall_timeout{1'500};
  std::chrono::milliseconds first_backoff{100};  ///< wait before trying again; doubles each time
  std::chrono::milliseconds max_backoff{500};
  std::stop_token stop = {};  ///< asked to stop, opening a source fails soon
  /// Called by any thread when trouble() of a source has changed, with what it is now; also while
  /// the source is being opened.
  std::function<void(const std::optional<std::string>&)> on_trouble = {};
  int open_attempts = 4;  ///< to open a source; later fetches are tried without end
};

}  // namespace pointreel
