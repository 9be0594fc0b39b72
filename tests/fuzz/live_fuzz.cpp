#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "tests/fuzz/target.h"
#include "tests/live_layer.h"

/// Parses messages of live streams, which are text or binary as the first byte says. An accepted
/// message must satisfy what the parser guarantees, and writing it must restore the input.
FUZZ_TARGET(live, .longest = 1 << 16, .repeats = true) {
  if (input.empty()) return;
  const ByteView message = input.subspan(1);
  if (input[0] % 2 == 0) {
    const auto layer = parse_live_layer(message);
    if (!layer) {
      if (layer.error().message.empty()) std::abort();
      return;
    }
    if (layer->layer >= layer->layers || layer->sizes.geometry == 0 ||
        total(layer->sizes) != layer->bytes.size()) {
      std::abort();
    }
    const Bytes again = write_live_layer(*layer);
    if (!std::equal(again.begin(), again.end(), message.begin(), message.end())) std::abort();
    return;
  }
  const std::string_view view = as_text(message);
  if (const auto publisher = parse_publisher_text(view); publisher && *publisher) {
    const std::string written = write_publisher_hello((*publisher)->hello, (*publisher)->identity);
    const auto again = parse_publisher_text(written).value().value();
    if (write_publisher_hello(again.hello, again.identity) != written) std::abort();
  }
  const auto text = parse_live_text(view);
  if (!text) {
    if (text.error().message.empty()) std::abort();
    return;
  }
  if (const auto* hello = std::get_if<LiveHello>(&*text)) {
    const std::string written = write_hello(*hello);
    const auto again = parse_live_text(written);
    if (!again || write_hello(std::get<LiveHello>(*again)) != written) std::abort();
  } else if (const auto* drops = std::get_if<LiveDrops>(&*text)) {
    if (!(std::get<LiveDrops>(parse_live_text(write_drops(*drops)).value()) == *drops)) {
      std::abort();
    }
  } else if (const auto* streams = std::get_if<LiveStreams>(&*text)) {
    if (!(std::get<LiveStreams>(parse_live_text(write_streams(*streams)).value()) == *streams)) {
      std::abort();
    }
  }
}
