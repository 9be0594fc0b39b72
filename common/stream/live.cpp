#include "common/stream/live.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "common/stream/json_fields.h"

namespace pointreel {
namespace {

using nlohmann::ordered_json;

constexpr std::uint32_t kMagic = 0x314c5250;  // "PRL1"
constexpr std::size_t kMaxStreamName = 64;

std::uint32_t header_checksum(ByteView header) {
  return static_cast<std::uint32_t>(checksum_of(header));
}

Result<LiveHello> hello_of(const JsonValue& root) {
  Fields fields(root);
  LiveHello hello;
  const std::uint64_t version = fields.integer("version", kMaxInteger);
  if (!fields.error() && version != kPackageVersion) {
    return fail(ErrorCode::unsupported, fmt::format("version {}, but this program reads only {}",
                                                    version, kPackageVersion));
  }
  read_reel_head(fields, hello);
  const std::optional<std::uint64_t> session = parse_hex(fields.text("session"));
  if (!session) fields.refuse("session", "is not 16 lowercase hexadecimal digits");
  const JsonValue* bounds = fields.value("bounds");
  TRY(fields.check());
  hello.session = *session;
  hello.bounds = TRY(at_place("bounds", parse_box(*bounds)));
  return hello;
}

}  // namespace

std::string write_hello(const LiveHello& hello) {
  ordered_json json = {{"type", "hello"},
                       {"version", kPackageVersion},
                       {"name", hello.name},
                       {"session", fmt::format("{:016x}", hello.session)},
                       {"codec", hello.codec}};
  if (!hello.entropy.empty()) json["entropy"] = hello.entropy;
  json["fps"] = hello.fps;
  json["up"] = std::string(1, hello.up);
  json["colors"] = hello.colors;
  json["normals"] = hello.normals;
  json["layers"] = hello.layer_names;
  json["bounds"] = box_json(hello.bounds);
  return dump(json);
}

std::string write_drops(const LiveDrops& drops) {
  return dump({{"type", "drops"}, {"frames", drops.frames}, {"layers", drops.layers}});
}

std::string write_end() { return dump({{"type", "end"}}); }

Result<LiveText> parse_live_text(std::string_view text) {
  if (text.size() > kMaxLiveText) {
    return fail(ErrorCode::limit, fmt::format("is longer than {} bytes", kMaxLiveText));
  }
  const JsonValue root = TRY(parse_json(text));
  Fields fields(root);
  const std::string type = fields.text("type");
  TRY(fields.check());
  if (type == "hello") return LiveText(TRY(at_place("hello", hello_of(root))));
  if (type == "drops") {
    const LiveDrops drops{fields.integer("frames", kMaxInteger),
                          fields.integer("layers", kMaxInteger)};
    if (fields.error()) return fail_at("drops", *fields.error());
    return LiveText(drops);
  }
  if (type == "end") return LiveText(LiveEnd{});
  return LiveText(LiveUnknown{});
}

Bytes write_live_header(const LiveLayer& layer) {
  Bytes header;
  header.reserve(kLiveHeaderSize);
  ByteWriter out(header);
  out.put(kMagic);
  out.put(layer.frame);
  out.put(layer.capture_us);
  out.put(layer.points);
  out.put(layer.layer);
  out.put(layer.layers);
  out.put(std::uint16_t{0});
  out.put(layer.sizes.geometry);
  out.put(layer.sizes.colors);
  out.put(layer.sizes.normals);
  out.put(header_checksum(header));
  return header;
}

Result<LiveLayer> parse_live_layer(ByteView message) {
  if (message.size() > kMaxLiveLayer) {
    return fail(ErrorCode::limit, fmt::format("layer: has more than {} bytes", kMaxLiveLayer));
  }
  ByteReader in(message);
  LiveLayer layer;
  const auto magic = in.get<std::uint32_t>();
  layer.frame = in.get<std::uint32_t>();
  layer.capture_us = in.get<std::uint64_t>();
  layer.points = in.get<std::uint32_t>();
  layer.layer = in.get<std::uint8_t>();
  layer.layers = in.get<std::uint8_t>();
  const auto reserved = in.get<std::uint16_t>();
  layer.sizes.geometry = in.get<std::uint32_t>();
  layer.sizes.colors = in.get<std::uint32_t>();
  layer.sizes.normals = in.get<std::uint32_t>();
  const auto checksum = in.get<std::uint32_t>();
  if (!in.ok()) return fail("layer: is shorter than its header");
  if (magic != kMagic) return fail("layer: does not begin with PRL1");
  if (checksum != header_checksum(message.first(kLiveHeaderSize - sizeof(checksum)))) {
    return fail("layer: its header is damaged");
  }
  if (reserved != 0) return fail("layer: reserved bytes are not 0");
  if (layer.layers == 0 || layer.layers > kMaxLayers || layer.layer >= layer.layers) {
    return fail(fmt::format("layer: its number is {} of {}", layer.layer, layer.layers));
  }
  if (layer.capture_us > kMaxInteger) return fail("layer: its capture time is out of range");
  layer.bytes = in.rest();
  if (layer.sizes.geometry == 0) return fail("layer: has no geometry");
  if (total(layer.sizes) != layer.bytes.size()) {
    return fail(fmt::format("layer: has {} bytes, but its chunks take {}", layer.bytes.size(),
                            total(layer.sizes)));
  }
  return layer;
}

bool is_stream_name(std::string_view name) {
  return name.size() <= kMaxStreamName && is_file_name(name);
}

}  // namespace pointreel
