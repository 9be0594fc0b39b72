#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/service/catalog.h"

/// From the head of a request to the head of its response: all that Pointreel does with HTTP,
/// without sockets.
namespace pointreel {

/// The untrusted contents of a request. Absent header fields are empty. Fields that come more than
/// once are joined by ", ", which RFC 9110, section 5.3, allows for each of these.
struct Request {
  std::string_view method, target;
  std::string range, if_range, if_match, if_none_match, authorization;
  std::string accept, accept_encoding;
  std::string protocols;   ///< Sec-WebSocket-Protocol: those that a browser offers
  std::string host;        ///< the Host field
  std::string origin;      ///< of the page in a browser that sends this; programs send none
  int host_fields = 0;     ///< the number of Host fields
  bool http_1_0 = false;   ///< Host may be absent
  bool has_body = false;   ///< a body follows, which no resource accepts
  bool websocket = false;  ///< asks for an upgrade to WebSocket
  bool forwarded = false;  ///< comes through a proxy
  /// Says in two ways, or in none that is known, where its body ends.
  bool bad_framing = false;
};

/// A response without the header fields that concern the connection.
struct Response {
  int status = 200;
  std::string fields;     ///< header lines, including Content-Length, each ending in CRLF
  std::string own_text;   ///< the body, if it was made for this response
  std::string_view text;  ///< otherwise the body, which belongs to `resource`
  SharedFile file;        ///< or, if not null, the body is `size` bytes of it from `offset`
  std::uint64_t offset = 0, size = 0;
  std::shared_ptr<const Resource> resource;  ///< owns what `text` points to
  bool close = false;  ///< nothing that follows on the connection can be understood
};

/// The decoded path of a request; or, if the response does not depend on the path, that response:
/// an error, or the answer to OPTIONS.
tl::expected<std::string, Response> path_of(const Request& request);

/// The response to a request for this resource; null: there is none.
Response respond(std::shared_ptr<const Resource> resource, const Request& request);

/// Finishes a response of any kind. Responses to HEAD get no body.
void finish_response(Response& response, const Request& request);

/// An error with one line of text for people. `extra_fields` consists of whole header lines.
Response error_response(int status, std::string_view line, std::string_view extra_fields = {});

/// The status line and all header fields, including `Date`, `Connection` and the empty line.
/// `unix_time` is in seconds.
std::string write_head(const Response& response, bool keep_alive, std::int64_t unix_time);

/// The date in the format of RFC 9110, section 5.6.7: "Sun, 06 Nov 1994 08:49:37 GMT".
std::string http_date(std::int64_t unix_time);

}  // namespace pointreel
