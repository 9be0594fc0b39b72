#include "server/serve/connection.h"

#include <ctime>
#include <string>
#include <string_view>

#include <boost/asio/buffer.hpp>

#include "server/serve/head_reader.h"
#include "server/serve/responder.h"

namespace pointreel {
namespace {

std::int64_t unix_time() { return static_cast<std::int64_t>(std::time(nullptr)); }

/// Reads one request's head: kHead, kRefused, or kEmpty if the connection ended first.
Task<HeadReader::State> read_head(Transport& transport, HeadReader& reader,
                                  std::chrono::milliseconds patience) {
  bool started = false;
  while (true) {
    const HeadReader::State state = reader.next();
    if (state == HeadReader::State::kHead || state == HeadReader::State::kRefused) co_return state;
    if (state == HeadReader::State::kPart && !started) {
      started = true;
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
  if (response.file.get() < 0) {
    const std::string_view body =
        response.error_text.empty() ? response.text : std::string_view(response.error_text);
    if (!co_await transport.write(head, !body.empty())) co_return false;
    co_return body.empty() || co_await transport.write(body, false);
  }
  if (!co_await transport.write(head, response.size > 0)) co_return false;
  co_return co_await transport.write_file(response.file.get(), response.offset, response.size);
}

}  // namespace

Task<void> serve_connection(std::shared_ptr<Transport> transport, const Catalog& catalog,
                            ConnectionTimes times) {
  HeadReader reader;
  const bool met = co_await transport->handshake();
  while (met) {
    const HeadReader::State state = co_await read_head(*transport, reader, times.header);
    if (state == HeadReader::State::kEmpty) break;
    const bool refused = state == HeadReader::State::kRefused;
    const Response response = refused ? reader.refusal() : respond(catalog, reader.request());
    const bool keep_alive = !refused && !response.close && reader.keep_alive();
    if (!co_await write(*transport, response, keep_alive)) break;
    if (!keep_alive) {
      co_await transport->linger();
      break;
    }
    transport->set_deadline(times.idle);
  }
  transport->close();
}

Task<void> refuse_connection(std::shared_ptr<Transport> transport) {
  const Response response =
      error_response(503, "too many connections; try again", "Retry-After: 1\r\n");
  if (co_await write(*transport, response, false)) co_await transport->linger();
  transport->close();
}

}  // namespace pointreel
