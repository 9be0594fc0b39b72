#include "codec/live/live.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <fmt/format.h>

#include "codec/core/json_fields.h"
#include "codec/core/reel_rules.h"
#include "codec/core/write_json.h"
#include "codec/live/header_checksum.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint32_t kLayerMagic = 0x314c5250;  // "PRL1"
constexpr std::size_t kMaxStreamName = 64;

/// All members of a hello but the session or the secret.
Result<LiveHello> hello_of(Fields& fields) {
  LiveHello hello;
  const std::uint64_t version = fields.integer("version", kMaxInteger);
  if (!fields.error() && version != kPackageVersion) {
    return fail(ErrorCode::unsupported,
                concat("version ", version, ", but this program reads only ", kPackageVersion));
  }
  read_reel_head(fields, hello);
  const JsonValue* bounds = fields.value("bounds");
  TRY(fields.check());
  TRY(check_head(hello));
  if (hello.group_frames > 0) return fail("codec: video is not sent live");
  hello.bounds = TRY(at_place("bounds", parse_box(*bounds)));
  return hello;
}

/// The numbers of servers that a hello may name.
std::vector<std::uint64_t> servers_of(Fields& fields) {
  std::vector<std::uint64_t> servers;
  if (!fields.has("servers")) return servers;
  const JsonValue array = fields.array("servers");
  if (fields.error()) return servers;
  for (JsonItems items(array); items.next();) {
    const auto text = items.value().string();
    const auto number = text ? parse_hex(*text) : std::nullopt;
    if (!number || servers.size() == kMaxLiveServers) {
      fields.refuse("servers", concat("is not a list of at most ", kMaxLiveServers,
                                      " texts of 16 lowercase hexadecimal digits"));
      return {};
    }
    servers.push_back(*number);
  }
  return servers;
}

Result<LiveStreams> streams_of(const JsonValue& root) {
  Fields fields(root);
  LiveStreams streams;
  const JsonValue array = fields.array("names");
  TRY(fields.check());
  for (JsonItems items(array); items.next();) {
    auto name = items.value().string();
    if (!name || !is_stream_name(*name)) return fail("one of its names is not that of a stream");
    if (streams.names.size() == kMaxLiveStreams) {
      return fail(ErrorCode::limit, concat("has more than ", kMaxLiveStreams, " names"));
    }
    streams.names.push_back(*std::move(name));
  }
  return streams;
}

Result<LiveHello> viewer_hello_of(const JsonValue& root) {
  Fields fields(root);
  const std::optional<std::uint64_t> session = parse_hex(fields.text("session"));
  if (!session) fields.refuse("session", "is not 16 lowercase hexadecimal digits");
  std::vector<std::uint64_t> servers = servers_of(fields);
  LiveHello hello = TRY(hello_of(fields));
  hello.session = *session;
  hello.servers = std::move(servers);
  return hello;
}

Result<PublisherHello> publisher_hello_of(const JsonValue& root) {
  Fields fields(root);
  constexpr const char* kBad = "is not 32 lowercase hexadecimal digits";
  const auto secret = parse_secret(fields.text("secret"));
  if (!secret) fields.refuse("secret", kBad);
  std::optional<LiveSecret> earlier;
  if (fields.has("earlier_secret")) {
    earlier = parse_secret(fields.text("earlier_secret"));
    if (!earlier) fields.refuse("earlier_secret", kBad);
  }
  return PublisherHello{TRY(hello_of(fields)), {secret.value_or(LiveSecret{}), earlier}};
}

std::string vector_text(const glm::dvec3& v) {
  return fmt::format("[{},{},{}]", dump(v.x), dump(v.y), dump(v.z));
}

/// A hello with these members for its session or secrets. Put together from single values, because
/// a tree of them that is being built does not survive a lack of memory, which must not end a
/// server.
std::string hello_text(const LiveHello& hello, std::string_view members) {
  std::string text = fmt::format(R"({{"type":"hello","version":{},"name":{},{},"codec":"{}")",
                                 kPackageVersion, dump(hello.name), members, hello.codec);
  if (!hello.entropy.empty()) text += fmt::format(R"(,"entropy":"{}")", hello.entropy);
  text += fmt::format(R"(,"fps":{},"up":"{}","colors":{},"normals":{})", dump(hello.fps),
                      hello.up.text(), hello.colors, hello.normals);
  for (std::size_t i = 0; i < hello.scalars.size(); ++i) {
    const ScalarRange& range = hello.scalars[i];
    text += fmt::format(R"({}{{"name":{},"min":{},"max":{},"labels":{}}})",
                        i == 0 ? R"(,"scalars":[)" : ",", dump(range.name), dump(range.least),
                        dump(range.most), range.labels);
  }
  if (!hello.scalars.empty()) text += ']';
  for (std::size_t i = 0; i < hello.servers.size(); ++i) {
    text += fmt::format(R"({}"{:016x}"{})", i == 0 ? R"(,"servers":[)" : ",", hello.servers[i],
                        i + 1 == hello.servers.size() ? "]" : "");
  }
  text += fmt::format(R"(,"layers":["{}"],"bounds":)", fmt::join(hello.layer_names, "\",\""));
  if (hello.bounds.empty()) return text + "null}";
  return text + fmt::format(R"({{"min":{},"max":{}}}}})", vector_text(hello.bounds.min),
                            vector_text(hello.bounds.max));
}

struct TypedText {
  JsonValue root;
  std::string type;
};

Result<TypedText> parse_typed(std::string_view text) {
  if (text.size() > kMaxLiveText) {
    return fail(ErrorCode::limit, concat("is longer than ", kMaxLiveText, " bytes"));
  }
  TypedText typed{TRY(parse_json(text)), {}};
  Fields fields(typed.root);
  typed.type = fields.text("type");
  TRY(fields.check());
  return typed;
}

}  // namespace

std::uint64_t frame_duration_us(double fps) {
  return static_cast<std::uint64_t>(std::llround(1e6 / fps));
}

std::string write_hello(const LiveHello& hello) {
  return hello_text(hello, fmt::format(R"("session":"{:016x}")", hello.session));
}

LiveSecret random_secret() {
  std::random_device device;
  LiveSecret secret;
  for (std::uint8_t& byte : secret) byte = static_cast<std::uint8_t>(device());
  return secret;
}

std::string secret_text(const LiveSecret& secret) {
  return fmt::format("{:02x}", fmt::join(secret, ""));
}

std::optional<LiveSecret> parse_secret(std::string_view text) {
  const auto first = parse_hex(text.substr(0, 16));
  const auto second = parse_hex(text.substr(std::min<std::size_t>(text.size(), 16)));
  if (!first || !second) return std::nullopt;
  LiveSecret secret;
  for (std::size_t i = 0; i < 8; ++i) {
    secret[i] = static_cast<std::uint8_t>(*first >> (56 - 8 * i));
    secret[8 + i] = static_cast<std::uint8_t>(*second >> (56 - 8 * i));
  }
  return secret;
}

std::string write_publisher_hello(const LiveHello& hello, const LiveIdentity& identity) {
  std::string members = fmt::format(R"("secret":"{}")", secret_text(identity.secret));
  if (identity.earlier)
    members += fmt::format(R"(,"earlier_secret":"{}")", secret_text(*identity.earlier));
  return hello_text(hello, members);
}

std::string write_drops(const LiveDrops& drops) {
  return fmt::format(R"({{"type":"drops","frames":{},"layers":{}}})", drops.frames, drops.layers);
}

std::string write_end() { return R"({"type":"end"})"; }

std::string write_streams(const LiveStreams& streams) {
  // Names consist of letters, digits, '.', '_' and '-', so nothing needs to be escaped.
  return streams.names.empty() ? R"({"type":"streams","names":[]})"
                               : fmt::format(R"({{"type":"streams","names":["{}"]}})",
                                             fmt::join(streams.names, "\",\""));
}

Result<LiveText> parse_live_text(std::string_view text) {
  const TypedText typed = TRY(parse_typed(text));
  if (typed.type == "hello") return LiveText(TRY(at_place("hello", viewer_hello_of(typed.root))));
  if (typed.type == "drops") {
    Fields fields(typed.root);
    const LiveDrops drops{fields.integer("frames", kMaxInteger),
                          fields.integer("layers", kMaxInteger)};
    if (fields.error()) return fail_at("drops", *fields.error());
    return LiveText(drops);
  }
  if (typed.type == "end") return LiveText(LiveEnd{});
  if (typed.type == "streams") return LiveText(TRY(at_place("streams", streams_of(typed.root))));
  return LiveText(LiveUnknown{});
}

Result<std::optional<PublisherHello>> parse_publisher_text(std::string_view text) {
  const TypedText typed = TRY(parse_typed(text));
  if (typed.type == "hello") {
    return std::optional(TRY(at_place("hello", publisher_hello_of(typed.root))));
  }
  if (typed.type == "drops" || typed.type == "end") {
    return fail("publishers may send only hellos and layers");
  }
  return std::optional<PublisherHello>();
}

Bytes write_live_header(const LiveLayer& layer) {
  Bytes header;
  header.reserve(kLiveHeaderSize);
  ByteWriter out(header);
  out.put(kLayerMagic);
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

Result<LiveLayer> next_live_layer(ByteView& messages) {
  ByteReader in(messages);
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
  if (magic != kLayerMagic) return fail("layer: does not begin with PRL1");
  if (checksum != header_checksum(messages.first(kLiveHeaderSize - sizeof(checksum)))) {
    return fail("layer: its header is damaged");
  }
  if (reserved != 0) return fail("layer: reserved bytes are not 0");
  if (layer.layers == 0 || layer.layers > kMaxLayers || layer.layer >= layer.layers) {
    return fail(concat("layer: its number is ", layer.layer, " of ", layer.layers));
  }
  if (layer.capture_us > kMaxCaptureTime) return fail("layer: its capture time is out of range");
  if (layer.sizes.geometry == 0) return fail("layer: has no geometry");
  const std::uint64_t size = total(layer.sizes);
  if (size > kMaxLiveLayer - kLiveHeaderSize) {
    return fail(ErrorCode::limit, concat("layer: has more than ", kMaxLiveLayer, " bytes"));
  }
  if (size > in.rest().size()) {
    return fail(concat("layer: has ", in.rest().size(), " bytes, but its chunks take ", size));
  }
  layer.bytes = in.rest().first(size);
  messages = in.rest().subspan(size);
  return layer;
}

Result<LiveLayer> parse_live_layer(ByteView message) {
  if (message.size() > kMaxLiveLayer) {
    return fail(ErrorCode::limit, concat("layer: has more than ", kMaxLiveLayer, " bytes"));
  }
  const std::size_t size = message.size();
  const LiveLayer layer = TRY(next_live_layer(message));
  if (!message.empty()) {
    return fail(concat("layer: has ", size - kLiveHeaderSize, " bytes, but its chunks take ",
                       total(layer.sizes)));
  }
  return layer;
}

bool is_stream_name(std::string_view name) {
  return name.size() <= kMaxStreamName && is_file_name(name);
}

bool is_stream_address(std::string_view url) {
  const std::string_view path = url.substr(0, url.find_first_of("?#"));
  const auto slash = path.rfind('/');
  return slash != path.npos && path.substr(0, slash).ends_with("/live") &&
         is_stream_name(path.substr(slash + 1));
}

}  // namespace pointreel
