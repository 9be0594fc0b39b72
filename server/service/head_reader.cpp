#include "server/service/head_reader.h"

#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <fmt/format.h>

namespace pointreel {
namespace {

namespace http = boost::beast::http;
using boost::system::error_code;

Request request_of(const http::request<http::empty_body>& message) {
  const auto joined = [&message](http::field name) {
    std::string value;
    const auto [begin, end] = message.equal_range(name);
    for (auto field = begin; field != end; ++field) {
      if (!value.empty()) value += ", ";
      value.append(field->value().data(), field->value().size());
    }
    return value;
  };
  Request request;
  request.method = {message.method_string().data(), message.method_string().size()};
  request.target = {message.target().data(), message.target().size()};
  request.range = joined(http::field::range);
  request.if_range = joined(http::field::if_range);
  request.if_match = joined(http::field::if_match);
  request.if_none_match = joined(http::field::if_none_match);
  request.host_fields = static_cast<int>(message.count(http::field::host));
  request.http_1_0 = message.version() < 11;
  request.authorization = joined(http::field::authorization);
  request.accept = joined(http::field::accept);
  request.accept_encoding = joined(http::field::accept_encoding);
  request.protocols = joined(http::field::sec_websocket_protocol);
  request.forwarded = message.count(http::field::forwarded) > 0 ||
                      message.count("X-Forwarded-For") > 0 || message.count("X-Real-IP") > 0 ||
                      message.count(http::field::via) > 0;
  request.host = joined(http::field::host);
  request.origin = joined(http::field::origin);
  request.websocket = message.method() == http::verb::get && !request.http_1_0 &&
                      http::token_list(message[http::field::connection]).exists("upgrade") &&
                      http::token_list(message[http::field::upgrade]).exists("websocket");
  const std::string length = joined(http::field::content_length);
  // Whoever is in front of this server may understand another combination of these, or another
  // coding, in another way, and take the body for a second request (RFC 9112, section 6.1).
  const bool coded = message.count(http::field::transfer_encoding) > 0;
  request.bad_framing =
      coded && (request.http_1_0 || message.count(http::field::content_length) > 0 ||
                !boost::beast::iequals(joined(http::field::transfer_encoding), "chunked"));
  request.has_body = message.chunked() || (!length.empty() && length != "0");
  return request;
}

}  // namespace

struct HeadReader::Parser {
  std::vector<char> bytes = std::vector<char>(kLimit);
  std::size_t begin = 0, end = 0;  ///< the bytes that have arrived and are still needed
  std::size_t parsed = 0;          ///< bytes from `begin` on that `http` has parsed
  std::size_t head = 0;            ///< size of the head, once it is complete
  std::optional<http::request_parser<http::empty_body>> http;
  error_code error;
  Request request;
};

HeadReader::HeadReader() : parser_(std::make_unique<Parser>()) {}
HeadReader::~HeadReader() = default;

std::span<char> HeadReader::space() {
  Parser& p = *parser_;
  if (p.begin > 0) {
    std::memmove(p.bytes.data(), p.bytes.data() + p.begin, p.end - p.begin);
    p.end -= p.begin;
    p.begin = 0;
  }
  return std::span(p.bytes).subspan(p.end);
}

void HeadReader::took(std::size_t size) { parser_->end += size; }

HeadReader::State HeadReader::next() {
  Parser& p = *parser_;
  if (p.head > 0 || !p.http) {
    p.begin += std::exchange(p.head, 0);
    p.parsed = 0;
    p.http.emplace();
    p.http->header_limit(kLimit);
  }
  if (p.begin == p.end) return State::kEmpty;
  p.error = {};
  const std::size_t from = p.begin + p.parsed;
  p.parsed += p.http->put(boost::asio::buffer(p.bytes.data() + from, p.end - from), p.error);
  if (p.error == http::error::need_more) p.error = {};
  if (p.error) return State::kRefused;
  if (p.http->is_header_done()) {
    p.head = p.parsed;
    p.request = request_of(p.http->get());
    return State::kHead;
  }
  // The parser takes the request line, and then all fields at once.
  if (p.end - p.begin < kLimit) return State::kPart;
  p.error = http::error::header_limit;
  return State::kRefused;
}

const Request& HeadReader::request() const { return parser_->request; }

bool HeadReader::keep_alive() const { return parser_->http->get().keep_alive(); }

std::string_view HeadReader::raw() const {
  return {parser_->bytes.data() + parser_->begin, parser_->end - parser_->begin};
}

Response HeadReader::refusal() const {
  const error_code error = parser_->error;
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return error_response(431,
                          fmt::format("the head of a request may have at most {} bytes", kLimit));
  }
  if (error == http::error::bad_version)
    return error_response(505, "this server supports HTTP/1.1");
  return error_response(400, "this is not an HTTP/1.1 request");
}

}  // namespace pointreel
