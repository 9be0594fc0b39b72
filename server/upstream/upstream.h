#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "codec/live/live.h"
#include "pointreel/error.h"
#include "server/relay/relay.h"

namespace pointreel {

/// Another server whose live streams a relay passes on.
struct UpstreamOptions {
  std::string url;     ///< ws(s)://HOST/live: all its streams; ws(s)://HOST/live/NAME: one of them
  std::string stream;  ///< the name there; empty: all
  /// The name here, in which '*' stands for the name there.
  std::string name = "*";
  std::string token, ca_file;  ///< as WebSocketOptions has them
  std::size_t max_message = kLiveHeaderSize + kMaxLiveLayer;
  /// Bytes of text per second. Every viewer gets them.
  double text_rate = 256.0 * 1024.0;
  /// Called with one line when the state of a connection changes, from several threads.
  std::function<void(const std::string& line)> say;
};

/// Reads URL, or NAME=URL, where NAME needs a '*' for all streams.
Result<UpstreamOptions> parse_upstream(const std::string& text);

/// Is a viewer of another server, and feeds what it gets to the relay: one connection for each
/// stream and, for all streams, one for their names. Connections that break are made again, half a
/// second later at most; where the other server or the relay refuses, ten seconds later at most.
///
/// Trust: the other server is as untrusted as a publisher. The relay checks its messages, which are
/// bounded like a publisher's, and an error ends the connection. It can occupy as many streams as
/// the relay has.
class Upstream {
 public:
  /// The relay must outlive it.
  static Result<std::unique_ptr<Upstream>> start(Relay& relay, UpstreamOptions options);
  virtual ~Upstream() = default;
};

}  // namespace pointreel
