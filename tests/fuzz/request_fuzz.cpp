#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <variant>

#include "server/relay/relay.h"
#include "server/serve/head_reader.h"
#include "server/serve/service.h"

/// Whatever comes on a connection, and in whatever pieces, the server finds the same requests in
/// it, holds no more than it says, and has a well-formed answer to each.
namespace {

using namespace pointreel;
using State = HeadReader::State;

/// What a connection's bytes come to.
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
      // Sooner or later, for what is malformed shows by what follows it.
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
      // Nothing that a request says may end the head early.
      if (!head.starts_with("HTTP/1.1 ") || head.find("\r\n\r\n") != head.size() - 4) std::abort();
      const std::size_t body = std::max(response.own_text.size(), response.text.size());
      if (response.file.get() >= 0 || response.size != body) std::abort();
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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  static Relay relay;
  ServiceOptions options;
  options.log = Log::Level::kOff;
  options.view_token = size % 2 == 0 ? "" : "token";
  Service service(*Catalog::load({}), &relay, options);
  const Conversation whole = converse(service, bytes, HeadReader::kLimit);
  const Conversation pieces = converse(service, bytes, 1 + size % 7);
  // A page of metrics counts what came before, so answers are compared but for it.
  if (whole.targets != pieces.targets) std::abort();
  if (bytes.find("metrics") == std::string_view::npos && whole.answers != pieces.answers) {
    std::abort();
  }
  return 0;
}
