#include "server/serve/connection.h"

#include <ctime>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <boost/asio/buffer.hpp>

#include "server/serve/websocket_session.h"
#include "server/service/head_reader.h"
#include "server/service/responder.h"

namespace pointreel {
namespace {

/// A target without what its query says, which may be a token.
std::string logged(std::string_view target) {
  const std::size_t query = target.find('?');
  std::string shown(target.substr(0, query));
  return query == std::string_view::npos ? shown : shown + "?...";
}

std::int64_t unix_time() { return static_cast<std::int64_t>(std::time(nullptr)); }

/// Reads the head of a request. Returns kHead, kRefused, or kEmpty if the connection ended before.
Task<HeadReader::State> read_head(Transport& transport, HeadReader& reader,
                                  ConnectionTable::Place& place,
                                  std::chrono::milliseconds patience) {
  bool started = false;
  while (true) {
    const HeadReader::State state = reader.next();
    if (state == HeadReader::State::kHead || state == HeadReader::State::kRefused) co_return state;
    if (state == HeadReader::State::kPart && !started) {
      started = true;
      place.busy();
      transport.set_deadline(patience);
    }
    const auto space = reader.space();
    const std::size_t size = co_await transport.read_some(asio::buffer(space.data(), space.size()));
    if (size == 0) co_return HeadReader::State::kEmpty;
    reader.took(size);
  }
}

Task<bool> write(Transport& transport, const Response& response, bool keep_alive) {
  const std::string head = write_head(response, keep_alive, unix_time());
  if (!response.file) {
    const std::string_view body =
        response.own_text.empty() ? response.text : std::string_view(response.own_text);
    if (!co_await transport.write(head, !body.empty())) co_return false;
    co_return body.empty() || co_await transport.write(body, false);
  }
  if (!co_await transport.write(head, response.size > 0)) co_return false;
  co_return co_await transport.write_file(response.file->get(), response.offset, response.size);
}

}  // namespace

Task<void> serve_connection(std::shared_ptr<Transport> transport, ConnectionTable::Place& place,
                            Peer peer, Service& service, const Limits& limits) {
  if (!co_await transport->handshake()) {
    ++service.metrics().failed_handshakes;
    service.log().write(Log::Level::kDebug, "tls.failed", {{"peer", peer.address}});
    transport->close();
    co_return;
  }
  HeadReader reader;
  SharedFile kept;  // The file of the last response: the next request is often for the same.
  while (true) {
    const HeadReader::State state =
        co_await read_head(*transport, reader, place, limits.header_timeout);
    if (state == HeadReader::State::kEmpty) break;
    place.busy();
    const auto begin = Clock::now();
    const bool refused = state == HeadReader::State::kRefused;
    std::shared_ptr<Wake> wake;
    if (!refused && reader.request().websocket) {
      wake = std::make_shared<Wake>(transport->executor());
    }
    auto answer = refused ? service.refuse(reader.refusal())
                          : service.answer(reader.request(), peer,
                                           wake ? wake->function() : std::function<void()>());
    if (auto* call = std::get_if<LiveCall>(&answer)) {
      co_await serve_websocket(transport, std::string(reader.raw()), std::move(*call),
                               std::move(wake), peer, service, limits);
      break;
    }
    const Response& response = std::get<Response>(answer);
    const bool keep_alive = !refused && !response.close && reader.keep_alive();
    const bool written = co_await write(*transport, response, keep_alive);
    if (written) {
      service.metrics().body_bytes.fetch_add(response.size, std::memory_order_relaxed);
    }
    if (service.log().writes(Log::Level::kInfo)) {
      const std::chrono::duration<double, std::milli> took = Clock::now() - begin;
      service.log().write(Log::Level::kInfo, "request",
                          {{"peer", peer.address},
                           {"method", refused ? "" : reader.request().method},
                           {"target", refused ? std::string() : logged(reader.request().target)},
                           {"status", std::int64_t{response.status}},
                           {"bytes", static_cast<std::int64_t>(response.size)},
                           {"ms", took.count()},
                           {"whole", written}});
    }
    if (response.file) kept = response.file;
    if (!written) break;
    if (!keep_alive) {
      co_await transport->linger();
      break;
    }
    place.idle(begin);
    transport->set_deadline(limits.idle_timeout);
  }
  transport->close();
}

Task<void> refuse_connection(std::shared_ptr<Transport> transport,
                             ConnectionTable::Refusal refusal) {
  const bool full = refusal == ConnectionTable::Refusal::kFull;
  const Response response =
      error_response(503,
                     full ? "too many connections; try again"
                          : "too many connections from your address; end some of them",
                     "Retry-After: 1\r\n");
  if (co_await write(*transport, response, false)) co_await transport->linger();
  transport->close();
}

}  // namespace pointreel
