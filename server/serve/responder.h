#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/serve/catalog.h"

/// From a request's head to a response's: everything that HTTP means to Pointreel, without a
/// socket.
namespace pointreel {

/// What a request says, untrusted. Header fields that are absent are empty; those that came more
/// than once are joined by ", ", as RFC 9110, section 5.3, allows for every one of them.
struct Request {
  std::string_view method, target;
  std::string range, if_range, if_match, if_none_match, authorization;
  int host_fields = 0;      ///< how many Host fields there were
  bool http_1_0 = false;    ///< Host may be absent
  bool has_body = false;    ///< it announces one; no resource takes any
  bool websocket = false;   ///< it asks to go on as a WebSocket
  bool forwarded = false;   ///< a proxy says that it comes from elsewhere
  bool has_origin = false;  ///< a page in a browser makes it
};

/// A response but for the fields that belong to the connection.
struct Response {
  int status = 200;
  std::string fields;     ///< header lines, each ended by CRLF, Content-Length among them
  std::string own_text;   ///< the body, made for this response; or
  std::string_view text;  ///< the body, of `resource`; or
  FileHandle file;        ///< the body is `size` bytes of this file from `offset`
  std::uint64_t offset = 0, size = 0;
  std::shared_ptr<const Resource> resource;  ///< what `text` points into
  bool close = false;  ///< what follows on the connection cannot be understood
};

/// The decoded path of a request for something; or what the request gets whatever there is: an
/// error, or the answer to OPTIONS.
tl::expected<std::string, Response> path_of(const Request& request);

/// What the request gets of the catalog.
Response respond(const Catalog& catalog, std::string_view path, const Request& request);

/// What is left to do to every response to `request`: HEAD gets no body.
void finish_response(Response& response, const Request& request);

/// An error as a line of text for a person. `extra_fields` are whole header lines.
Response error_response(int status, std::string_view line, std::string_view extra_fields = {});

/// The status line and all header fields, `Date` and `Connection` included, up to the empty line.
/// `unix_time` in seconds.
std::string write_head(const Response& response, bool keep_alive, std::int64_t unix_time);

/// RFC 9110, section 5.6.7: "Sun, 06 Nov 1994 08:49:37 GMT".
std::string http_date(std::int64_t unix_time);

}  // namespace pointreel
