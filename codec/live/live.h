#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

/// The messages of live streams, which publishers send and viewers receive: PROTOCOL.md, "Live".
/// Text messages are JSON objects with a "type"; a binary message is one layer of a frame.
///
/// Trust: the parsers take hostile bytes. They check the range of every number, and every size
/// against the bytes that arrived. Binary messages are not copied, and memory for text is bounded
/// by its length. The content of a layer's chunks is not checked here but by the codec.
namespace pointreel {

/// The longest messages that are accepted, in bytes. The longest hello takes less than half of its
/// limit.
inline constexpr std::size_t kMaxLiveText = 8u << 10;
inline constexpr std::size_t kMaxLiveLayer = 64u << 20;
/// The size of the header of a binary message.
inline constexpr std::size_t kLiveHeaderSize = 40;
/// The most servers that a stream passes through, and the most streams of one server.
inline constexpr std::size_t kMaxLiveServers = 8, kMaxLiveStreams = 64;

/// Describes the stream to viewers. It is the first message, and is sent again when something in it
/// changes; it then applies from the next frame on.
struct LiveHello : ReelHead {
  /// As long as it stays the same, frame numbers and times continue, even after a lost connection;
  /// with a new session they begin again. The server derives it from the publisher's secret, which
  /// it does not reveal.
  std::uint64_t session = 0;
  Box bounds;  ///< the bounds of all points so far; may be empty
  /// The servers through which the stream has come, that of the publisher first. Each chooses its
  /// number at random when it starts. Publishers send none.
  std::vector<std::uint64_t> servers;

  bool operator==(const LiveHello&) const = default;
};

/// The nominal duration of a frame in microseconds.
std::uint64_t frame_duration_us(double fps);

/// Chosen at random by a publisher when it starts, and known only to it and the server. With it the
/// publisher, and nobody else, continues its session after a lost connection.
using LiveSecret = std::array<std::uint8_t, 16>;

LiveSecret random_secret();
std::string secret_text(const LiveSecret& secret);  ///< 32 hexadecimal digits
std::optional<LiveSecret> parse_secret(std::string_view text);

/// By which the server recognises a publisher.
struct LiveIdentity {
  LiveSecret secret = random_secret();
  /// That of a publisher that has ended, whose name this one takes over while it is reserved.
  std::optional<LiveSecret> earlier = {};
};

/// The first message of a publisher, which describes the stream to the server.
struct PublisherHello {
  LiveHello hello;  ///< without a session
  LiveIdentity identity;
};

/// One layer of one frame. Frames come in order, and so do the layers of each frame, base first.
/// Frames and fine layers may be missing, but never a layer that is coarser than one that comes.
struct LiveLayer {
  std::uint32_t frame = 0;       ///< counts the frames of the session; increases
  std::uint8_t layer = 0;        ///< 0 is the base
  std::uint8_t layers = 1;       ///< the number of layers that the frame has, 1 to 8
  std::uint64_t capture_us = 0;  ///< Unix time in microseconds, by the publisher's clock; increases
  std::uint32_t points = 0;      ///< the number of points before encoding
  Chunks<std::uint32_t> sizes;   ///< the sizes of the chunks in `bytes`
  ByteView bytes;                ///< not owned
};

/// From a relay to one viewer: how much the viewer has missed since it joined, because it could not
/// receive it in time.
struct LiveDrops {
  std::uint64_t frames = 0;  ///< frames that were dropped entirely
  std::uint64_t layers = 0;  ///< layers that were dropped, including those of such frames

  bool operator==(const LiveDrops&) const = default;
};

/// From a relay: the publisher has disconnected. If it comes back, a hello follows.
struct LiveEnd {
  bool operator==(const LiveEnd&) const = default;
};

/// From a server to one that relays its streams: the names of those that are being published.
struct LiveStreams {
  std::vector<std::string> names;

  bool operator==(const LiveStreams&) const = default;
};

/// A text message of a type that this version does not know and ignores.
struct LiveUnknown {
  bool operator==(const LiveUnknown&) const = default;
};
using LiveText = std::variant<LiveHello, LiveDrops, LiveEnd, LiveStreams, LiveUnknown>;

std::string write_hello(const LiveHello& hello);
/// The same from a publisher: with its secrets in place of the session.
std::string write_publisher_hello(const LiveHello& hello, const LiveIdentity& identity);
std::string write_drops(const LiveDrops& drops);
std::string write_end();
/// At most kMaxLiveStreams of them fit into a text.
std::string write_streams(const LiveStreams& streams);
/// Errors: `unsupported` for a hello of another version, `limit` for more than kMaxLiveText bytes,
/// otherwise `invalid`.
Result<LiveText> parse_live_text(std::string_view text);
/// For the texts of publishers, which may send only hellos; nothing if the text is of an unknown
/// type. The errors are the same.
Result<std::optional<PublisherHello>> parse_publisher_text(std::string_view text);

/// The header of a layer's message, which its chunks follow; `bytes` is ignored.
Bytes write_live_header(const LiveLayer& layer);
/// `bytes` of the result point into the message. Errors: `limit` for more than kMaxLiveLayer bytes,
/// otherwise `invalid`.
Result<LiveLayer> parse_live_layer(ByteView message);
/// The first of several such messages that follow each other, which it takes away from `messages`.
Result<LiveLayer> next_live_layer(ByteView& messages);

/// True for 1 to 64 letters, digits, '.', '_' and '-' that do not begin with '.'.
bool is_stream_name(std::string_view name);
/// Whether the path of a URL is that of a stream: it ends in /live/NAME.
bool is_stream_address(std::string_view url);
inline constexpr const char* kNoStreamAddress =
    "does not end in /live/ and a stream's name, as in ws://HOST:8090/live/NAME";

}  // namespace pointreel
