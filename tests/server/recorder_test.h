#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/live/live.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "server/inspect/inspect.h"
#include "server/relay/recorder.h"
#include "tests/live_frames.h"
#include "tests/live_layer.h"
#include "tests/packed_clouds.h"

/// Recordings of frames that decode.
namespace pointreel {

inline constexpr std::uint64_t kStart = 1'700'000'000'000'000;
inline constexpr std::uint64_t kPeriod = 40'000;

inline LiveHello real_hello(std::uint64_t session = 1) {
  LiveHello hello = plain_hello(session);
  hello.fps = 25.0;
  hello.colors = true;
  hello.normals = true;
  hello.bounds = {{-2, -2, -2}, {2, 2, 2}};
  return hello;
}

/// A frame that decodes, with messages as a publisher sends them.
inline std::vector<LiveMessage> real_frame(std::uint32_t number, double along = 0.0) {
  OctreeOptions octree;
  octree.entropy = Entropy::none;
  octree.depth = DepthRule::fixed(9);
  EncodeOptions options;
  options.codec = octree;
  const auto encoded =
      encode_frame(ellipsoid(100 + number), {glm::dvec3(-2.0 + along), 4.0}, options).value();
  std::vector<LiveMessage> messages;
  for (const Chunks<Bytes>& layer : encoded.layers) {
    Bytes bytes;
    for (const Bytes* chunk : {&layer.geometry, &layer.colors, &layer.normals}) {
      bytes.insert(bytes.end(), chunk->begin(), chunk->end());
    }
    LiveLayer header;
    header.frame = number;
    header.layer = static_cast<std::uint8_t>(messages.size());
    header.layers = static_cast<std::uint8_t>(encoded.layers.size());
    header.capture_us = kStart + number * kPeriod;
    header.points = encoded.source_points;
    header.sizes = {static_cast<std::uint32_t>(layer.geometry.size()),
                    static_cast<std::uint32_t>(layer.colors.size()),
                    static_cast<std::uint32_t>(layer.normals.size())};
    header.bytes = bytes;
    messages.push_back(
        {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_layer(header))});
  }
  return messages;
}

inline void give(LiveSink& sink, const std::vector<LiveMessage>& messages) {
  for (const LiveMessage& message : messages) {
    sink.layer(parse_live_layer(*message.bytes).value(), message);
  }
}

inline void give_frames(LiveSink& sink, std::uint32_t first, std::uint32_t count) {
  for (std::uint32_t i = first; i < first + count; ++i) give(sink, real_frame(i));
}

/// The layers of a frame that was captured at another time.
inline void give_at(LiveSink& sink, std::uint32_t number, std::uint64_t capture_us) {
  for (const LiveMessage& message : real_frame(number)) {
    LiveLayer layer = parse_live_layer(*message.bytes).value();
    layer.capture_us = capture_us;
    sink.layer(layer, message);
  }
}

class RecorderTest : public testing::Test {
 protected:
  LiveRecorderOptions options() {
    LiveRecorderOptions options;
    options.folder = temporary_.path() / "recordings";
    options.name = "stage";
    options.segment_us = 5 * kPeriod;
    options.say = [this](const std::string& line) { said_.push_back(line); };
    return options;
  }
  std::filesystem::path package(const std::string& name = "stage") const {
    return temporary_.path() / "recordings" / name;
  }
  /// Returns the faults of a package and counts its frames.
  std::vector<std::string> faults(const std::filesystem::path& folder, std::uint32_t& frames) {
    const auto report = verify(folder);
    if (!report) return {report.error().message};
    frames = report->frames;
    std::vector<std::string> found;
    for (const Fault& fault : report->faults) found.push_back(fault.file + ": " + fault.what);
    return found;
  }

  TemporaryFolder temporary_;
  std::vector<std::string> said_;
};

}  // namespace pointreel
