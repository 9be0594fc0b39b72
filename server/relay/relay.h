#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/stream/live.h"
#include "pointreel/error.h"
#include "server/relay/viewer_queue.h"

/// Live streams, from their publishers to their viewers, without a socket. Any thread may call
/// anything; what belongs to one connection is called by one thread at a time.
///
/// Trust: publishers' messages are untrusted. Headers and text are checked (live.h) and that layers
/// come in order; what is in a layer is handed on as it is. Memory is bounded: of each stream its
/// newest frame, and for each viewer what ViewerLimits says.
namespace pointreel {

/// Something that gets all of a stream: a recorder. Called in order, one call at a time, while the
/// stream waits: it must not block, and not call the relay.
class LiveSink {
 public:
  virtual ~LiveSink() = default;
  virtual void hello(const LiveHello& hello) = 0;
  /// `layer.bytes` point into `message`.
  virtual void layer(const LiveLayer& layer, const LiveMessage& message) = 0;
  /// The publisher has gone.
  virtual void end() = 0;
};

struct RelayOptions {
  std::size_t max_streams = 64;  ///< beyond it the one that ended first makes room
  ViewerLimits viewer;
  /// Makes those that get all of a stream of this name, and end with it; may be empty.
  std::function<std::vector<std::shared_ptr<LiveSink>>(const std::string& name)> sinks;
};

struct StreamStatistics {
  std::string name;
  bool publishing = false;
  std::size_t viewers = 0;
  std::uint64_t frames = 0, layers = 0, bytes = 0;  ///< that were published
  std::uint64_t sent_bytes = 0;                     ///< that viewers took, those gone included
  LiveDrops drops;                                  ///< of all viewers, those gone included
  std::uint64_t newest_capture_us = 0;              ///< of the newest frame; 0: none yet
};

/// One publisher of a stream. Destroying it tells the viewers that the publisher has gone.
class Publication {
 public:
  virtual ~Publication() = default;
  /// The first message must be a hello. After an error the publisher's connection must end, and be
  /// told why. An error, too, once the same session has connected anew and taken this one's place.
  virtual Result<void> message(LiveMessage message) = 0;
};

/// One viewer of a stream.
class Viewer {
 public:
  virtual ~Viewer() = default;
  /// What to send next. Ask as late as possible, when the socket takes bytes: what is newest is
  /// decided then. Nothing: nothing waits, and `wake` is called once something does.
  virtual std::optional<LiveMessage> next() = 0;
};

struct RelayState;

class Relay {
 public:
  explicit Relay(RelayOptions options = {});
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// An error if a stream cannot be called so, or if there are too many. Whether somebody else
  /// publishes it turns out with the hello: with the same session it is a publisher that has
  /// connected anew, and takes the place of its old connection.
  Result<std::unique_ptr<Publication>> publish(const std::string& name);

  /// A viewer gets the hello and the newest frame as far as it has come, then what follows. A
  /// stream whose publisher has gone stays, until there are too many. An error if there is none.
  /// `wake` is called from any thread, while the stream waits: it must not block, and not call the
  /// relay or the viewer. It is not called any more once the viewer is destroyed.
  Result<std::unique_ptr<Viewer>> join(const std::string& name, std::function<void()> wake);

  std::vector<StreamStatistics> statistics() const;

 private:
  std::shared_ptr<RelayState> state_;
};

}  // namespace pointreel
