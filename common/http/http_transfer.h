#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/pace.h"
#include "common/http/aws_access.h"
#include "common/http/http_failure.h"
#include "common/http/http_options.h"
#include "common/http/redirect.h"
#include "pointreel/bytes.h"

// As in curl/curl.h, so that only http_transfer.cpp and http_client.cpp include that.
typedef void CURL;

namespace pointreel {

/// What to ask a server for: a whole file of at most `limit` bytes, or, if `size` is not 0, `size`
/// bytes from `offset` on of a file that has `total` bytes.
struct HttpWanted {
  std::string url = {};
  std::uint64_t offset = 0, size = 0, total = 0, limit = 0;
  std::string tag = {};  ///< entity tag of a whole file: one that still has it is not sent again
  bool fresh = false;    ///< asks caches for a new copy, over a new connection

  bool is_range() const { return size > 0; }
  bool is_whole_file() const { return size == total; }
};

/// One request, made in as many attempts as it takes. Bytes of a range that have come are not asked
/// for again. For one thread.
///
/// Trust: the server may be hostile. A body is bounded while it arrives, after decompression, takes
/// memory as it comes, and is kept only if the status and Content-Range match the request. It may
/// be compressed once. A redirect to another host is refused before anything is sent there, unless
/// HttpOptions::follow_redirects is set, and one from https to http always. Signed requests follow
/// none.
class HttpTransfer {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Bytes per second that an answer must bring on average. At 56 kbit/s, each of eight brings
  /// three times as much.
  static constexpr double kLeastRate = 256;

  /// `access`: what to sign requests with, if anything. It and `options` outlive the transfer.
  HttpTransfer(HttpWanted wanted, const HttpOptions& options,
               const std::optional<AwsAccess>& access);
  ~HttpTransfer();
  HttpTransfer(const HttpTransfer&) = delete;
  HttpTransfer& operator=(const HttpTransfer&) = delete;

  const HttpWanted& wanted() const { return wanted_; }

  /// Begins an attempt and returns a handle that is ready to be performed, the same each time; null
  /// if there is no memory. A kept connection is not used if it has been idle for longer than
  /// `max_idle`.
  CURL* begin(bool new_connection, std::chrono::seconds max_idle);
  /// Call this after the handle was performed. `code` is a CURLcode. Nothing if all is well.
  std::optional<HttpFailure> finish(int code);
  /// Call this instead if no byte came for as long as `limit`.
  HttpFailure stalled(std::chrono::milliseconds limit) const;
  /// Call this instead if `due` has passed.
  HttpFailure too_slow(Time now) const;

  /// When the attempt's request was sent; none while there is no connection.
  std::optional<Time> sent_at() const;
  /// When the newest byte of the attempt came, headers included; none if none did.
  std::optional<Time> newest_byte() const { return newest_byte_; }
  /// When the attempt's answer is too slow, unless more of it comes before.
  Time due() const { return pace_.due(); }
  /// Bytes of the body that are still to come; for a whole file, the most that may come.
  std::uint64_t missing() const;

  Bytes take_body() { return std::move(body_); }
  bool unchanged() const { return unchanged_; }    ///< `wanted().tag` still holds
  const std::string& tag() const { return tag_; }  ///< entity tag of the answer; may be empty

  struct Listener {
    virtual ~Listener() = default;
    /// A piece of the body has come. `first`: it is the attempt's first.
    virtual void on_bytes(const HttpTransfer& transfer, Time now, std::size_t size, bool first) = 0;
  };
  Listener* listener = nullptr;

 private:
  static std::size_t on_body(char* data, std::size_t, std::size_t size, void* user);
  static std::size_t on_header(char* data, std::size_t, std::size_t size, void* user);
  bool accept_body();
  bool is_range_asked_for() const;
  bool may_follow(std::string_view location);
  long status() const;
  /// Whether the answer says how long its body is.
  bool has_length() const;

  const HttpWanted wanted_;
  const HttpOptions& options_;
  const std::optional<AwsAccess>& access_;
  CURL* const handle_;
  void* headers_ = nullptr;
  Bytes body_;
  // What follows is about the attempt.
  std::string range_, content_range_, tag_;
  std::string refusal_;           ///< the beginning of the body, if it is not kept
  Redirect redirect_;             ///< the newest
  std::array<char, 256> said_{};  ///< libcurl's words for what went wrong: CURL_ERROR_SIZE
  Time begun_{};
  std::optional<Time> newest_byte_;
  Pace pace_{kLeastRate};
  std::uint64_t asked_for_ = 0;  ///< bytes, if a range is asked for
  std::uint64_t came_ = 0, discarded_ = 0;
  int compressions_ = 0;  ///< how many times the body was compressed
  bool accepted_ = false, wrong_range_ = false, too_long_ = false, unchanged_ = false;
};

}  // namespace pointreel
