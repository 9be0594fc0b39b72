#include "server/service/responder.h"

#include <array>
#include <ctime>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "server/service/entity_tag.h"
#include "server/service/range_header.h"
#include "server/service/request_target.h"

namespace pointreel {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

std::string_view reason_phrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 204:
      return "No Content";
    case 206:
      return "Partial Content";
    case 304:
      return "Not Modified";
    case 308:
      return "Permanent Redirect";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 409:
      return "Conflict";
    case 412:
      return "Precondition Failed";
    case 413:
      return "Content Too Large";
    case 416:
      return "Range Not Satisfiable";
    case 421:
      return "Misdirected Request";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "";
  }
}

/// The response to OPTIONS. It is the same for every path, so that it does not reveal which paths
/// exist.
Response options_response() {
  Response response;
  response.status = 204;
  response.fields = fmt::format("Allow: {}\r\n", kMethods);
  return response;
}

Response resource_response(const Resource& resource, const Request& request) {
  Response response;
  auto fields = std::back_inserter(response.fields);
  const auto put_validators = [&] {
    fmt::format_to(fields, "ETag: {}\r\nCache-Control: {}\r\n{}", resource.etag,
                   resource.cache_control, resource.fields);
  };
  // The order of the conditions follows RFC 9110, section 13.2.2.
  if (!request.if_match.empty() && !matches_strongly(request.if_match, resource.etag)) {
    return error_response(412, "the resource does not match If-Match");
  }
  if (matches_weakly(request.if_none_match, resource.etag)) {
    response.status = 304;
    put_validators();
    return response;
  }
  RangeAnswer range;
  if (request.method == "GET" &&
      (request.if_range.empty() || matches_strongly(request.if_range, resource.etag))) {
    range = answer_range(request.range, resource.size);
  }
  if (range.kind == RangeAnswer::Kind::kUnsatisfiable) {
    return error_response(416, fmt::format("the resource has {} bytes", resource.size),
                          fmt::format("Content-Range: bytes */{}\r\n", resource.size));
  }
  if (range.kind == RangeAnswer::Kind::kWhole) range.size = resource.size;

  if (resource.kind == Resource::Kind::kFile) {
    auto file = open_resource(resource);
    if (!file && file.error() == OpenError::kBusy) {
      return error_response(503, "too many files are open; try again", "Retry-After: 1\r\n");
    }
    if (!file) {
      return error_response(500, "the package changed on disk; pack it again");
    }
    response.file = *std::move(file);
  } else {
    response.text = std::string_view(resource.text).substr(range.offset, range.size);
  }
  response.offset = range.offset;
  response.size = range.size;
  fmt::format_to(fields, "Content-Type: {}\r\nContent-Length: {}\r\nAccept-Ranges: bytes\r\n",
                 resource.content_type, range.size);
  put_validators();
  if (range.kind == RangeAnswer::Kind::kPart) {
    response.status = 206;
    fmt::format_to(fields, "Content-Range: bytes {}-{}/{}\r\n", range.offset,
                   range.offset + range.size - 1, resource.size);
  }
  return response;
}

/// The date of a response, which is formatted only once per second.
const std::string& cached_date(std::int64_t unix_time) {
  thread_local std::int64_t written = -1;
  thread_local std::string date;
  if (unix_time != written) {
    date = http_date(unix_time);
    written = unix_time;
  }
  return date;
}

}  // namespace

Response error_response(int status, std::string_view line, std::string_view extra_fields) {
  Response response;
  response.status = status;
  response.own_text = fmt::format("{}\n", line);
  response.size = response.own_text.size();
  response.fields = fmt::format(
      "Content-Type: text/plain; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n"
      "{}",
      response.size, extra_fields);
  return response;
}

tl::expected<std::string, Response> path_of(const Request& request) {
  const auto refuse = [](Response response) { return tl::unexpected(std::move(response)); };
  if (request.bad_framing) {
    return refuse(error_response(
        400, "a request may have either Content-Length or Transfer-Encoding: chunked"));
  }
  if (request.host_fields > 1 || (request.host_fields == 0 && !request.http_1_0)) {
    return refuse(error_response(400, "a request needs exactly one Host field"));
  }
  if (request.method != "GET" && request.method != "HEAD" && request.method != "OPTIONS") {
    return refuse(error_response(405, "only GET, HEAD and OPTIONS are supported",
                                 fmt::format("Allow: {}\r\n", kMethods)));
  }
  if (request.has_body) return refuse(error_response(413, "requests must not have a body"));
  if (request.method == "OPTIONS" && request.target == "*") return refuse(options_response());
  auto path = decode_target(request.target);
  if (!path) return refuse(error_response(400, path.error().message));
  if (request.method == "OPTIONS") return refuse(options_response());
  return *std::move(path);
}

Response respond(std::shared_ptr<const Resource> resource, const Request& request) {
  if (resource == nullptr) {
    return error_response(404, "no such resource; GET / lists all packages");
  }
  if (resource->kind == Resource::Kind::kRedirect) {
    return error_response(308, "the manifest is " + resource->text,
                          fmt::format("Location: {}\r\n", resource->text));
  }
  Response response = resource_response(*resource, request);
  response.resource = std::move(resource);
  return response;
}

void finish_response(Response& response, const Request& request) {
  // Bodies of requests are never read, so nothing after such a head can be understood.
  response.close = request.has_body || request.bad_framing;
  if (request.method == "HEAD") {
    response.file = nullptr;
    response.text = {};
    response.own_text.clear();
    response.size = 0;
  }
}

std::string http_date(std::int64_t unix_time) {
  static constexpr std::array kDays = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  static constexpr std::array kMonths = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                         "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::time_t time = unix_time;
  std::tm utc{};
  if (::gmtime_r(&time, &utc) == nullptr) return {};
  return fmt::format("{}, {:02} {} {:04} {:02}:{:02}:{:02} GMT",
                     kDays[static_cast<std::size_t>(utc.tm_wday)], utc.tm_mday,
                     kMonths[static_cast<std::size_t>(utc.tm_mon)], utc.tm_year + 1900, utc.tm_hour,
                     utc.tm_min, utc.tm_sec);
}

std::string write_head(const Response& response, bool keep_alive, std::int64_t unix_time) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\n"
      "Date: {}\r\n"
      "Server: pointreel\r\n"
      "Connection: {}\r\n"
      "X-Content-Type-Options: nosniff\r\n"
      "{}\r\n",
      response.status, reason_phrase(response.status), cached_date(unix_time),
      keep_alive ? "keep-alive" : "close", response.fields);
}

}  // namespace pointreel
