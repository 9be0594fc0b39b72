#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <variant>

#include "server/relay/relay.h"
#include "server/service/head_reader.h"
#include "server/service/service.h"
#include "tests/fuzz/target.h"

/// Whatever arrives on a connection, and in whatever pieces, the server must find the same requests
/// in it, buffer no more than its limit, and have a well-formed answer to each request.
namespace pointreel::fuzz::request {

using State = HeadReader::State;

/// The outcome of a connection's bytes.
struct Conversation {
  std::string targets, answers;
};

Conversation converse(Service& service, std::string_view bytes, std::size_t piece) {
  Conversation talk;
  HeadReader reader;
  Peer peer;
  peer.loopback = true;
  while (true) {
    const State state = reader.next();
    if (state == State::kRefused) {
      // When this is noticed depends on how the bytes arrive, so it is not compared.
      if (reader.refusal().status < 400) std::abort();
      return talk;
    }
    if (state == State::kHead) {
      const Request& request = reader.request();
      talk.targets += request.target;
      auto answer = service.answer(request, peer, [] {});
      if (std::holds_alternative<LiveCall>(answer)) {
        if (!request.websocket || reader.raw().empty()) std::abort();
        talk.answers += "upgrade";
        return talk;
      }
      const Response& response = std::get<Response>(answer);
      const std::string head = write_head(response, reader.keep_alive(), 0);
      // No text of a request may end the head of the answer early.
      if (!head.starts_with("HTTP/1.1 ") || head.find("\r\n\r\n") != head.size() - 4) std::abort();
      const std::size_t body = std::max(response.own_text.size(), response.text.size());
      if (response.file || response.size != body) std::abort();
      talk.answers += head.substr(0, 12) + std::to_string(response.fields.size());
      if (response.close || !reader.keep_alive()) return talk;
      continue;
    }
    if (bytes.empty()) return talk;
    const auto space = reader.space();
    if (space.empty()) std::abort();
    const std::size_t size = std::min({piece, space.size(), bytes.size()});
    std::memcpy(space.data(), bytes.data(), size);
    reader.took(size);
    bytes.remove_prefix(size);
  }
}

}  // namespace pointreel::fuzz::request

FUZZ_TARGET(request) {
  const std::string_view bytes = as_text(input);
  static Relay relay;
  ServiceOptions options;
  options.log = Log::Level::kOff;
  options.view_token = bytes.size() % 2 == 0 ? "" : "token";
  static constexpr std::array<PageFile, 2> kPage = {{
      {"index.html", "page", "br", "gzip"},
      {"a.js", "script", "", ""},
  }};
  options.page = Page(kPage);
  Service service(*Catalog::load({}), &relay, options);
  const Conversation whole = converse(service, bytes, HeadReader::kLimit);
  const Conversation pieces = converse(service, bytes, 1 + bytes.size() % 7);
  // Pages of metrics count earlier requests, so they are excluded from the comparison.
  if (whole.targets != pieces.targets) std::abort();
  if (bytes.find("metrics") == std::string_view::npos && whole.answers != pieces.answers) {
    std::abort();
  }
}
