#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "codec/live/live.h"
#include "codec/live/live_queue.h"
#include "codec/octree/frame_header.h"
#include "tests/live_layer.h"

/// Live messages whose layers hold no real chunks, for tests that look at headers only.
namespace pointreel {

inline LiveHello plain_hello(std::uint64_t session = 1) {
  LiveHello hello;
  hello.name = "plain";
  hello.session = session;
  hello.codec = "octree";
  hello.entropy = "none";
  hello.layer_names = {"base", "middle", "full"};
  return hello;
}

/// The hello of the publisher of that number.
inline LiveMessage publisher_message(std::uint8_t number = 1,
                                     const LiveHello& hello = plain_hello()) {
  return text_message(write_publisher_hello(hello, {LiveSecret{number}}));
}

/// The base begins with a frame header if it has the size for it.
inline LiveMessage layer_message(std::uint32_t frame, std::uint8_t layer, std::uint8_t layers = 3,
                                 std::size_t size = kFrameHeaderSize,
                                 FrameHeader of_frame = {.source_points = 4, .cube = {}}) {
  Bytes bytes;
  if (layer == 0 && size >= kFrameHeaderSize) {
    of_frame.layers = std::max(of_frame.layers, layers);
    write_frame_header(of_frame, frame, bytes);
  }
  bytes.resize(size, static_cast<std::uint8_t>(frame));
  LiveLayer header;
  header.frame = frame;
  header.layer = layer;
  header.layers = layers;
  header.capture_us = 1'000'000 + 33'333u * frame;
  header.points = of_frame.source_points;
  header.sizes.geometry = static_cast<std::uint32_t>(size);
  header.bytes = bytes;
  return {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_layer(header))};
}

/// A message in brief: "7.0" is the base of frame 7, and a text message is given by its type.
inline std::string brief(const LiveMessage& message) {
  if (message.kind == LiveMessage::Kind::text) {
    const std::string text(message.bytes->begin(), message.bytes->end());
    const auto parsed = parse_live_text(text);
    if (!parsed) return "?";
    if (const auto* drops = std::get_if<LiveDrops>(&*parsed)) {
      return "drops " + std::to_string(drops->frames) + " " + std::to_string(drops->layers);
    }
    return std::holds_alternative<LiveHello>(*parsed) ? "hello" : "end";
  }
  const auto layer = parse_live_layer(*message.bytes);
  return layer ? std::to_string(layer->frame) + "." + std::to_string(layer->layer) : "?";
}

}  // namespace pointreel
