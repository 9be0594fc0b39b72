#include "codec/live/live.h"

#include <chrono>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "client/source/live_frames.h"
#include "client/web/wasm/errors.h"
#include "client/web/wasm/module.h"
#include "client/web/wasm/numbers.h"
#include "client/web/wasm/reel.h"
#include "codec/live/live_sound.h"

using namespace pointreel;

struct PrLive {
  LiveFrames frames;
  std::optional<PrReel> reel;  ///< of the last hello
  // Of the frame that was given last:
  Bytes bytes;
  std::vector<std::uint32_t> sizes;
};

namespace {

PrReel reel_of_hello(const LiveHello& hello) {
  Manifest manifest;
  static_cast<ReelHead&>(manifest) = hello;
  manifest.bounds = hello.bounds;
  manifest.live = LiveManifest{hello.session};
  return reel_of(std::move(manifest));
}

}  // namespace

PrLive* pr_live_new() { return new PrLive; }
void pr_live_free(PrLive* live) { delete live; }

PrMessage pr_live_text(PrLive* live, const char* text, std::uint32_t size) {
  auto message = parse_live_text({text, size});
  if (!message) {
    live->frames.add_bad();
    report(message.error());
    return PR_MESSAGE_BAD;
  }
  if (auto* hello = std::get_if<LiveHello>(&*message)) {
    live->reel = reel_of_hello(*hello);
    live->frames.add(std::move(*hello));
    return PR_MESSAGE_HELLO;
  }
  if (const auto* drops = std::get_if<LiveDrops>(&*message)) {
    live->frames.set_dropped(drops->layers);
    return PR_MESSAGE_DROPS;
  }
  return std::holds_alternative<LiveEnd>(*message) ? PR_MESSAGE_END : PR_MESSAGE_UNKNOWN;
}

PrError pr_live_layer(PrLive* live, const std::uint8_t* bytes, std::uint32_t size, double now_us) {
  const SharedBytes message(Bytes(bytes, bytes + size));
  const auto layer = parse_live_layer(message.view());
  if (!layer) {
    live->frames.add_bad();
    return report(layer.error());
  }
  live->frames.add(*layer, message.part(kLiveHeaderSize, layer->bytes.size()), time_of(now_us));
  return PR_OK;
}

const PrLiveSound* pr_live_sound(const std::uint8_t* bytes, std::uint32_t size) {
  static PrLiveSound answer;
  const auto sound = parse_live_sound({bytes, size});
  if (!sound) {
    report(sound.error());
    return nullptr;
  }
  answer = {static_cast<double>(sound->number), static_cast<double>(sound->capture_us),
            static_cast<double>(sound->samples), static_cast<double>(kSoundHeaderSize)};
  return &answer;
}

void pr_live_reconnected(PrLive* live) { live->frames.reconnected(); }

const PrReel* pr_live_reel(const PrLive* live) { return live->reel ? &*live->reel : nullptr; }

const PrLiveFrame* pr_live_next(PrLive* live, double now_us) {
  static PrLiveFrame answer;
  const auto frame = live->frames.next(time_of(now_us));
  if (!frame) return nullptr;
  live->bytes.clear();
  live->sizes.clear();
  for (const FetchedLayer& layer : frame->frame.layers) {
    live->bytes.insert(live->bytes.end(), layer.bytes.begin(), layer.bytes.end());
    live->sizes.insert(live->sizes.end(),
                       {layer.sizes.geometry, layer.sizes.colors, layer.sizes.normals});
  }
  answer = {static_cast<double>(frame->number),
            static_cast<double>(frame->capture_us),
            static_cast<double>(frame->frame.layers.size()),
            static_cast<double>(frame->layers_sent),
            address(live->bytes.data()),
            static_cast<double>(live->bytes.size()),
            address(live->sizes.data())};
  return &answer;
}

double pr_live_due(const PrLive* live) {
  const auto due = live->frames.due();
  if (!due) return -1.0;
  return std::chrono::duration<double, std::micro>(due->time_since_epoch()).count();
}

const PrLiveCounts* pr_live_counts(const PrLive* live) {
  static PrLiveCounts answer;
  const LiveCounts& counts = live->frames.counts();
  answer = {static_cast<double>(counts.frames),        static_cast<double>(counts.skipped),
            static_cast<double>(counts.dropped),       static_cast<double>(counts.bad),
            static_cast<double>(counts.reconnections), static_cast<double>(counts.bytes)};
  return &answer;
}
