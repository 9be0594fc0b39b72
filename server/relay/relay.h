#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codec/live/live.h"
#include "codec/live/live_queue.h"
#include "codec/live/live_sound.h"
#include "pointreel/error.h"

/// Passes live streams on from their publishers, or from other servers, to their viewers, without
/// sockets. Any thread may
/// call anything, but each Publication and each Viewer only one thread at a time.
///
/// Trust: the messages of publishers and of other servers are untrusted. Their headers, texts
/// (live.h), order and frame headers are checked, so that a package can be made of whatever is
/// accepted (reel_rules.h); the contents of chunks are passed on unchecked. Memory is bounded: it
/// holds the newest frame of each stream, and for each viewer what LiveQueueOptions allows. The
/// secrets of publishers are not kept, and nothing that viewers, sinks or statistics get reveals
/// them (session.h).
namespace pointreel {

/// Gets everything of a stream, for instance to record it. The calls come in order, one at a time,
/// while the stream waits: they must not block, and must not call the relay.
class LiveSink {
 public:
  virtual ~LiveSink() = default;
  virtual void hello(const LiveHello& hello) = 0;
  /// `layer.bytes` points into `message`, whose bytes are in one piece.
  virtual void layer(const LiveLayer& layer, const LiveMessage& message) = 0;
  /// `sound.packet` points into `message`.
  virtual void sound(const LiveSound& /*sound*/, const LiveMessage& /*message*/) {}
  /// The publisher has gone.
  virtual void end() = 0;
  /// Called every second after `end`, until it says that there is nothing left to do.
  virtual bool settle() { return true; }
};

/// A number that hardly any other server has.
std::uint64_t random_server();

struct RelayOptions {
  using Clock = std::chrono::steady_clock;
  /// A further one replaces the stream that ended first.
  std::size_t max_streams = kMaxLiveStreams;
  std::uint64_t server = random_server();  ///< stands for this server in LiveHello::servers
  /// For this time after a connection is lost, the stream's name belongs to its publisher.
  std::chrono::milliseconds grace{10'000};
  std::function<Clock::time_point()> now = [] { return Clock::now(); };
  LiveQueueOptions viewer;  ///< the queue of each viewer
  /// Creates the sinks of a stream of this name, which are destroyed with it. May be empty.
  std::function<std::vector<std::shared_ptr<LiveSink>>(const std::string& name)> sinks;
};

struct StreamStatistics {
  std::string name;
  bool publishing = false;
  std::size_t viewers = 0;
  std::uint64_t frames = 0, layers = 0, bytes = 0;  ///< published
  std::uint64_t sent_bytes = 0;  ///< taken by viewers, including those that have left
  LiveDrops drops;               ///< of all viewers, including those that have left
  std::size_t hops = 0;          ///< servers between the publisher and this one
  LiveDrops lost;                ///< what those before this one could not send in time
  /// From the capture of the newest frame until its base was here, by the clocks of the publisher
  /// and of this machine.
  std::int64_t lag_us = 0;
  std::uint64_t newest_capture_us = 0;  ///< Unix time of the newest frame; 0 if there is none
};

/// A publisher of a stream. Destroying it tells the viewers that the publisher has gone.
class Publication {
 public:
  virtual ~Publication() = default;
  /// Takes a message as it came from the network, in one piece. The first must be a hello; before
  /// it the publication holds nothing, neither a stream nor its name. After an error the connection
  /// to the publisher must be closed, with the message as the reason. It is also an error if
  /// somebody else owns the name, if there are too many streams, or if the same publisher has
  /// connected again and replaced this publication.
  virtual Result<void> message(LiveMessage message) = 0;
  /// Whether a hello has been accepted.
  virtual bool greeted() const = 0;
  /// The publisher has said that it will not come back: others may have the name at once.
  virtual void end() = 0;
};

/// A viewer of a stream.
class Viewer {
 public:
  virtual ~Viewer() = default;
  /// The message to send next. Ask as late as possible, when the socket accepts bytes, because the
  /// answer depends on what is newest. Returns nothing if nothing waits; `wake` is called once when
  /// something does.
  virtual std::optional<LiveMessage> next() = 0;
};

struct RelayState;

class Relay {
 public:
  explicit Relay(RelayOptions options = {});
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// An error if the name is not a stream's name. Who has the stream is decided when the hello
  /// comes: a name belongs to the publisher that uses it, and for RelayOptions::grace after its
  /// connection was lost. With the same secret it is the same publisher, which has reconnected and
  /// replaces its old connection.
  Result<std::unique_ptr<Publication>> publish(const std::string& name);

  /// The same for a stream that comes from another server, whose messages to viewers it takes. When
  /// the connection is lost, the name is free at once. A stream that has come through this server
  /// before, or through kMaxLiveServers, is an error. An `end` from there ends the publication
  /// until the next hello.
  Result<std::unique_ptr<Publication>> receive(const std::string& name);

  /// Gets the names of the streams that are being published, LiveStreams, and all of them again
  /// whenever they change. `wake` is as in join().
  std::unique_ptr<Viewer> watch(std::function<void()> wake);

  /// A viewer gets the hello and as much of the newest frame as has come, and then everything that
  /// follows. Streams remain when their publisher has gone, until there are too many. An error if
  /// there is no such stream. `sound`: the viewer gets that, too. `wake` is called from any thread,
  /// while the stream waits: it must not block, and must not call the relay or the viewer. It is
  /// not called after the viewer is destroyed.
  Result<std::unique_ptr<Viewer>> join(const std::string& name, std::function<void()> wake,
                                       bool sound = false);

  std::vector<StreamStatistics> statistics() const;

 private:
  std::shared_ptr<RelayState> state_;
};

}  // namespace pointreel
