#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

/// The messages of live streams, as a publisher sends them and as a viewer gets them: PROTOCOL.md,
/// "Live". Text messages are JSON objects with a "type"; a binary message is one layer of a frame.
///
/// Trust: these parse hostile bytes. Every number is checked against its range and every size
/// against the bytes that are there; binary messages are not copied, and memory for text is bounded
/// by its length. What a layer's chunks hold is for the codec to find out.
namespace pointreel {

/// Longer messages are refused, whoever sends them.
inline constexpr std::size_t kMaxLiveText = 64u << 10;
inline constexpr std::size_t kMaxLiveLayer = 64u << 20;
/// Of the header of a binary message.
inline constexpr std::size_t kLiveHeaderSize = 40;

/// What a stream is. The first message; it comes again when something in it changes, and what it
/// says then counts from the next frame on.
struct LiveHello : ReelHead {
  /// Chosen at random by the publisher when it starts: while it stays, frame numbers and times go
  /// on, whoever has lost a connection meanwhile. With another one they begin anew.
  std::uint64_t session = 0;
  Box bounds;  ///< of all points so far; may be empty

  bool operator==(const LiveHello&) const = default;
};

/// One layer of one frame. Frames come in order, and so do the layers of each, base first; frames
/// and layers may be missing, but no layer below one that comes.
struct LiveLayer {
  std::uint32_t frame = 0;       ///< its number since the session began, which rises
  std::uint8_t layer = 0;        ///< 0 is the base
  std::uint8_t layers = 1;       ///< that the frame has, 1 to 8
  std::uint64_t capture_us = 0;  ///< Unix time in microseconds, by the publisher's clock; rises
  std::uint32_t points = 0;      ///< of the source's frame
  Chunks<std::uint32_t> sizes;   ///< of the chunks in `bytes`: geometry, colours, normals
  ByteView bytes;                ///< not owned
};

/// From a relay to one viewer: what it could not take in time and did not get, since it joined.
struct LiveDrops {
  std::uint64_t frames = 0;  ///< of which nothing came
  std::uint64_t layers = 0;  ///< of all frames

  bool operator==(const LiveDrops&) const = default;
};

/// From a relay: the publisher has gone. It may come back, with a hello.
struct LiveEnd {
  bool operator==(const LiveEnd&) const = default;
};

/// A text message of a type that this version does not know, which is to be ignored.
struct LiveUnknown {
  bool operator==(const LiveUnknown&) const = default;
};
using LiveText = std::variant<LiveHello, LiveDrops, LiveEnd, LiveUnknown>;

std::string write_hello(const LiveHello& hello);
std::string write_drops(const LiveDrops& drops);
std::string write_end();
Result<LiveText> parse_live_text(std::string_view text);
/// A text that must be a hello.
Result<LiveHello> parse_hello(std::string_view text);

/// Header and bytes. `sizes` add up to `bytes`.
Bytes write_live_layer(const LiveLayer& layer);
/// `bytes` of the result point into the message.
Result<LiveLayer> parse_live_layer(ByteView message);

/// Whether a stream may be called so: 1 to 64 letters, digits, '.', '_' and '-', not beginning with
/// '.'.
bool is_stream_name(std::string_view name);

}  // namespace pointreel
