#include "common/http/http_transfer.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include <curl/curl.h>
#include <fmt/format.h>

#include "common/base/words.h"
#include "common/http/aws_signature.h"
#include "common/http/http_request.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

using Kind = HttpFailure::Kind;

/// The body of an error page is read up to here, to keep the connection, and thrown away.
constexpr std::uint64_t kMaxErrorPage = 64 * 1024;
/// What an object store says about it is in the first bytes.
constexpr std::size_t kMaxRefusal = 2048;
constexpr std::size_t kMaxTag = 256;

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

/// The value of the header field `name`, which is lower case, if the line is one.
std::optional<std::string_view> field(std::string_view line, std::string_view name) {
  const bool matches =
      line.size() > name.size() && line[name.size()] == ':' &&
      std::equal(name.begin(), name.end(), line.begin(), [](char wanted, char given) {
        return wanted == static_cast<char>(std::tolower(static_cast<unsigned char>(given)));
      });
  if (!matches) return std::nullopt;
  line.remove_prefix(name.size() + 1);
  while (!line.empty() && is_space(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
  return line;
}

/// The number of codings in a list such as "gzip, chunked" that curl undoes by decompressing.
int compressions(std::string_view list) {
  int count = 0;
  while (!list.empty()) {
    std::string_view coding = list.substr(0, list.find(','));
    list.remove_prefix(std::min(coding.size() + 1, list.size()));
    while (!coding.empty() && is_space(coding.front())) coding.remove_prefix(1);
    if (!coding.empty() && !coding.starts_with("chunked") && !coding.starts_with("identity")) {
      ++count;
    }
  }
  return count;
}

double seconds(std::chrono::milliseconds time) { return static_cast<double>(time.count()) / 1000; }

/// Whether it is an address that Amazon's tools presigned. Those of CloudFront and of tokens that
/// are valid for a folder look different.
bool is_signed_for_one_file(const std::string& url) {
  const std::size_t query = url.find('?');
  return query != std::string::npos && url.find("X-Amz-Signature=", query) != std::string::npos;
}

}  // namespace

HttpTransfer::HttpTransfer(HttpWanted wanted, const HttpOptions& options,
                           const std::optional<AwsAccess>& access)
    : wanted_(std::move(wanted)), options_(options), access_(access), handle_(curl_easy_init()) {}

HttpTransfer::~HttpTransfer() {
  curl_easy_cleanup(handle_);
  curl_slist_free_all(static_cast<curl_slist*>(headers_));
}

long HttpTransfer::status() const { return status_of(handle_); }

bool HttpTransfer::has_length() const {
  curl_off_t length = -1;
  curl_easy_getinfo(handle_, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  return length >= 0;
}

CURL* HttpTransfer::begin(bool new_connection, std::chrono::seconds max_idle) {
  if (handle_ == nullptr) return nullptr;
  content_range_.clear();
  tag_.clear();
  redirect_ = {};
  newest_byte_.reset();
  pace_.ended();
  came_ = 0;
  refusal_.clear();
  discarded_ = 0;
  compressions_ = 0;
  accepted_ = wrong_range_ = too_long_ = unchanged_ = false;
  if (!wanted_.is_range()) body_.clear();
  begun_ = std::chrono::steady_clock::now();

  prepare_request(handle_, wanted_.url, options_);
  const auto set = [this](CURLoption option, auto value) {
    curl_easy_setopt(handle_, option, value);
  };
  set(CURLOPT_PRIVATE, static_cast<void*>(this));
  static_assert(sizeof(said_) >= CURL_ERROR_SIZE);
  said_[0] = '\0';
  set(CURLOPT_ERRORBUFFER, said_.data());
  // A signature is for one host, and goes to no other.
  set(CURLOPT_FOLLOWLOCATION, access_ ? 0L : 1L);
  set(CURLOPT_MAXREDIRS, 4L);
  set(CURLOPT_BUFFERSIZE, 256L * 1024);
  set(CURLOPT_FRESH_CONNECT, new_connection || wanted_.fresh ? 1L : 0L);
  set(CURLOPT_MAXAGE_CONN, static_cast<long>(max_idle.count()));
  if (!options_.token.empty() && !access_) {
    set(CURLOPT_HTTPAUTH, static_cast<long>(CURLAUTH_BEARER));
    set(CURLOPT_XOAUTH2_BEARER, options_.token.c_str());
  }
  curl_slist_free_all(static_cast<curl_slist*>(headers_));
  curl_slist* list = nullptr;
  if (wanted_.fresh) list = curl_slist_append(list, "Cache-Control: no-cache");
  if (!wanted_.tag.empty())
    list = curl_slist_append(list, ("If-None-Match: " + wanted_.tag).c_str());
  if (access_) list = sign(handle_, list, *access_);
  headers_ = list;
  set(CURLOPT_HTTPHEADER, static_cast<curl_slist*>(headers_));
  if (wanted_.is_range()) {
    range_ = fmt::format("{}-{}", wanted_.offset + body_.size(), wanted_.offset + wanted_.size - 1);
    asked_for_ = wanted_.size - body_.size();
    set(CURLOPT_RANGE, range_.c_str());
  } else {
    set(CURLOPT_ACCEPT_ENCODING, "gzip");  // manifests are text, which many servers compress
  }
  set(CURLOPT_WRITEFUNCTION, &HttpTransfer::on_body);
  set(CURLOPT_WRITEDATA, static_cast<void*>(this));
  set(CURLOPT_HEADERFUNCTION, &HttpTransfer::on_header);
  set(CURLOPT_HEADERDATA, static_cast<void*>(this));
  return handle_;
}

std::size_t HttpTransfer::on_header(char* data, std::size_t, std::size_t size, void* user) {
  auto& self = *static_cast<HttpTransfer*>(user);
  const std::string_view line(data, size);
  const auto now = std::chrono::steady_clock::now();
  self.newest_byte_ = now;
  self.pace_.came(size, now);
  // Only the last response counts: redirects have earlier ones.
  if (line.starts_with("HTTP/")) {
    self.content_range_.clear();
    self.tag_.clear();
    self.compressions_ = 0;
  }
  // A kilobyte that was compressed twice may stand for a gigabyte that decompresses to nothing: the
  // limit on the body would not notice the work.
  for (const std::string_view name : {"content-encoding", "transfer-encoding"}) {
    if (const auto value = field(line, name)) self.compressions_ += compressions(*value);
  }
  if (self.compressions_ > 1) return 0;
  if (const auto value = field(line, "location"); value && !self.may_follow(*value)) return 0;
  if (const auto value = field(line, "content-range")) self.content_range_ = *value;
  if (const auto value = field(line, "etag"); value && value->size() <= kMaxTag) self.tag_ = *value;
  return size;
}

/// Whether a redirect from the address of the answer that is coming leads to where it may.
bool HttpTransfer::may_follow(std::string_view location) {
  if (const long answered = status(); answered < 300 || answered >= 400) return true;
  const char* from = nullptr;
  curl_easy_getinfo(handle_, CURLINFO_EFFECTIVE_URL, &from);
  redirect_ =
      judge_redirect(from == nullptr ? "" : from, std::string(location), options_.follow_redirects);
  return redirect_.verdict == Redirect::Verdict::follow;
}

bool HttpTransfer::is_range_asked_for() const {
  return content_range_ == fmt::format("bytes {}/{}", range_, wanted_.total) ||
         content_range_ == fmt::format("bytes {}/*", range_);
}

/// Decides at the first piece of a body with status 200 or 206 whether it is kept.
bool HttpTransfer::accept_body() {
  const long answered = status();
  if (wanted_.is_range() && answered == 206 && !is_range_asked_for()) {
    wrong_range_ = true;
    return false;
  }
  if (wanted_.is_range() && answered == 200) {
    if (!wanted_.is_whole_file()) return false;
    body_.clear();  // all of it comes again
    asked_for_ = wanted_.size;
  }
  return accepted_ = true;
}

std::size_t HttpTransfer::on_body(char* data, std::size_t, std::size_t size, void* user) {
  auto& self = *static_cast<HttpTransfer*>(user);
  const auto now = std::chrono::steady_clock::now();
  self.newest_byte_ = now;
  self.pace_.came(size, now);
  if (const long answered = self.status(); answered != 200 && answered != 206) {
    self.discarded_ += size;
    self.refusal_.append(data, std::min(size, kMaxRefusal - self.refusal_.size()));
    return self.discarded_ <= kMaxErrorPage ? size : 0;
  }
  if (!self.accepted_ && !self.accept_body()) return 0;
  const std::uint64_t limit = self.wanted_.is_range() ? self.asked_for_ : self.wanted_.limit;
  if (self.came_ + size > limit) {
    self.too_long_ = true;
    return 0;
  }
  if (self.listener != nullptr) self.listener->on_bytes(self, now, size, self.came_ == 0);
  self.came_ += size;
  self.body_.insert(self.body_.end(), data, data + size);
  return size;
}

std::optional<HttpTransfer::Time> HttpTransfer::sent_at() const {
  curl_off_t microseconds = 0;
  curl_easy_getinfo(handle_, CURLINFO_PRETRANSFER_TIME_T, &microseconds);
  if (microseconds <= 0) return std::nullopt;
  return begun_ + std::chrono::microseconds(microseconds);
}

std::uint64_t HttpTransfer::missing() const {
  return (wanted_.is_range() ? wanted_.size : wanted_.limit) - body_.size();
}

HttpFailure HttpTransfer::stalled(std::chrono::milliseconds limit) const {
  return http_failure(
      Kind::passing, newest_byte_ ? fmt::format("nothing came for {:g} s, after {}", seconds(limit),
                                                counted(body_.size(), "byte"))
                                  : fmt::format("no answer within {:g} s", seconds(limit)));
}

HttpFailure HttpTransfer::too_slow(Time now) const {
  const auto time = std::chrono::round<std::chrono::seconds>(now - pace_.began());
  return http_failure(
      Kind::passing,
      fmt::format("only {} came within {} s", counted(pace_.size(), "byte"), time.count()),
      "check the link, and what the server is");
}

std::optional<HttpFailure> HttpTransfer::finish(int code) {
  const long answered = status();
  if (answered >= 400) {
    HttpFailure failed = failure_of_status(answered, refusal_);
    if (answered == 403 && failed.advice.empty() && is_signed_for_one_file(wanted_.url))
      failed.advice = "an address that was presigned is valid for one file only; see the guide";
    return failed;
  }
  if (access_ && answered >= 300 && answered != 304)
    return failure_of_store_redirect(answered, refusal_);
  if (redirect_.verdict == Redirect::Verdict::not_secure)
    return http_failure(
        Kind::final,
        fmt::format("the server redirects from https to {}", without_secrets(redirect_.to)),
        "that is not followed, because it is not secure");
  if (redirect_.verdict == Redirect::Verdict::not_http)
    return http_failure(
        Kind::final,
        fmt::format("the server redirects to {}, which is not an http:// or https:// address",
                    without_secrets(redirect_.to)));
  if (redirect_.verdict == Redirect::Verdict::another_host)
    return http_failure(
        Kind::final,
        fmt::format("the server redirects to another host, {}", without_secrets(redirect_.to)),
        "give that address, or --follow-redirects");
  if (wanted_.is_range() && !wanted_.is_whole_file() && answered == 200)
    return {
        {Kind::final, {"the server sends whole files instead of ranges", ErrorCode::unsupported}}};
  // Of a file that comes whole, and whose length was announced, the server has no other bytes.
  const bool is_whole = wanted_.is_range() && answered == 200 && has_length();
  if (too_long_)
    return http_failure(
        is_whole ? Kind::final : Kind::doubtful,
        fmt::format("the server sends more than the {} bytes expected{}",
                    wanted_.is_range() ? asked_for_ : wanted_.limit,
                    is_whole ? " (the file is longer than its manifest says)" : ""));
  if (compressions_ > 1)
    return http_failure(Kind::final, "the server compresses the answer more than once");
  if (wrong_range_ || (code == CURLE_OK && answered == 206 && !is_range_asked_for()))
    return http_failure(
        Kind::doubtful,
        fmt::format("asked for bytes {} of {}, but the server sends \"{}\": the package has "
                    "changed, or the server is at fault",
                    range_, wanted_.total, content_range_));
  if (code != CURLE_OK)
    return failure_of_transfer(code, wanted_.url, options_, body_.size(), said_.data());
  if (answered == 304 && !wanted_.tag.empty()) {
    unchanged_ = true;
    return std::nullopt;
  }
  if (answered != 200 && !(wanted_.is_range() && answered == 206))
    return http_failure(Kind::doubtful, fmt::format("the server answers {} where {} is expected",
                                                    answered, wanted_.is_range() ? 206 : 200));
  if (wanted_.is_range() && body_.size() != wanted_.size)
    return http_failure(
        is_whole ? Kind::final : Kind::passing,
        fmt::format("{} came instead of {}{}", counted(body_.size(), "byte"), wanted_.size,
                    is_whole ? " (the file is shorter than its manifest says)" : ""));
  return std::nullopt;
}

}  // namespace pointreel
