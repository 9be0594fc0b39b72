#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "client/source/fetched.h"
#include "codec/files/reading.h"
#include "common/http/http_options.h"
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

struct SourceOptions : HttpOptions {  ///< token, ca_file and times are for WebSocket too
  /// Of folders of files, which do not tell it; 30 if it is not given, and not for recordings.
  std::optional<double> fps = {};
  std::string topic = {};    ///< of recordings that have several
  Reading reading = {};      ///< of files: what is not to be guessed
  Placement placement = {};  ///< of the points of files
  /// Receives lines about files: what is left out, and how they are read.
  std::function<void(const std::string&)> say = {};
  bool sound = false;                       ///< live streams are asked for theirs: OnSound
  std::uint64_t max_memory = kFrameMemory;  ///< DecodeLimits::max_memory
};

}  // namespace pointreel
