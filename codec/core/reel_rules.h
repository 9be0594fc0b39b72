#pragma once

#include <cstdint>

#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

/// The rules that reel.json, the hellos of live streams and their frames have in common
/// (PROTOCOL.md). A reader applies them to what it has parsed, and a relay to what a publisher
/// sends, before it becomes part of a manifest: whatever is accepted live can be written, and
/// whatever is written is accepted by readers.
///
/// An error begins with the name of the member that is wrong.
///
/// Trust: the values may be hostile. Nothing is allocated but the text of an error.
namespace pointreel {

/// The most frames of a group of video.
inline constexpr int kMostGroupFrames = 64;

/// The times of captures are at most this, in microseconds, so that times and durations of any
/// frames, including the last one's own duration (at most 1e6 / kMinFps), stay within kMaxInteger.
inline constexpr std::uint64_t kMaxCaptureTime = (std::uint64_t{1} << 53) - 1 - 1'000'000'000'000;

/// The name, the codec and its entropy coding, the frame rate, the axis and the names of the
/// layers.
Result<void> check_head(const ReelHead& head);

/// A box is empty, or it and its extent are finite.
Result<void> check_box(const Box& box);
/// A cube and its far corner are finite, and its edge is above 0.
Result<void> check_cube(const Cube& cube);

/// The sizes of a frame's chunks in one layer. `refines` says that the frame has the layer before,
/// or that this is the first.
Result<void> check_chunks(const ReelHead& head, std::size_t layer,
                          const Chunks<std::uint32_t>& sizes, bool refines);

/// Everything in a manifest, beginning with its head.
Result<void> check_manifest(const Manifest& manifest);

}  // namespace pointreel
