#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "client/source/source.h"

// As in curl/curl.h, which nobody else needs.
typedef void CURL;

namespace pointreel {

/// What is asked for: a whole file of at most `limit` bytes, or, if `size` is not 0, so many bytes
/// from `offset` on of a file that has `total`.
struct HttpWanted {
  std::string url = {};
  std::uint64_t offset = 0, size = 0, total = 0, limit = 0;
  std::string tag = {};  ///< whole files: an entity tag; one that has it still is not sent again
  bool fresh = false;    ///< past caches, over a new connection

  bool is_range() const { return size > 0; }
  bool is_whole_file() const { return size == total; }
};

/// Why an attempt failed, and whether another one is worth it.
struct HttpFailure {
  enum class Kind {
    final,     ///< the server will say the same again
    doubtful,  ///< an answer that makes no sense: damaged on its way, or the server's fault
    passing,   ///< no connection, a broken one, no answer in time, 5xx
  };
  Kind kind;
  Error error;
};

/// One request, over as many attempts as it takes: of a range, what has come is not asked for
/// again. For one thread.
///
/// Trust: the server may be hostile. A body is bounded while it arrives, takes memory as it comes,
/// and is kept only if status and Content-Range are those of what was asked for.
class HttpTransfer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `options` outlives the transfer.
  HttpTransfer(HttpWanted wanted, const SourceOptions& options);
  ~HttpTransfer();
  HttpTransfer(const HttpTransfer&) = delete;
  HttpTransfer& operator=(const HttpTransfer&) = delete;

  const HttpWanted& wanted() const { return wanted_; }

  /// Begins an attempt: a handle that is ready to be performed, the same each time; null if there
  /// is no memory. Of connections that are kept those idle for longer than `max_idle` are not used.
  CURL* begin(bool new_connection, std::chrono::seconds max_idle);
  /// After the handle was performed. `code` is a CURLcode. Nothing if all is well.
  std::optional<HttpFailure> finish(int code);
  /// Instead, if no byte came for so long a time.
  HttpFailure stalled(std::chrono::milliseconds limit) const;

  /// Of the attempt: when its request was sent; none while there is no connection.
  std::optional<Time> sent_at() const;
  /// When the newest byte came, headers included; none if none did.
  std::optional<Time> newest_byte() const { return newest_byte_; }
  /// Bytes of the body that are still to come; of a whole file, as many as may come.
  std::uint64_t missing() const;

  Bytes take_body() { return std::move(body_); }
  bool unchanged() const { return unchanged_; }    ///< `wanted().tag` still holds
  const std::string& tag() const { return tag_; }  ///< entity tag of what came, if it has one

  /// Called for each piece of the body that comes. `first`: of the attempt.
  struct Listener {
    virtual ~Listener() = default;
    virtual void on_bytes(const HttpTransfer& transfer, Time now, std::size_t size, bool first) = 0;
  };
  Listener* listener = nullptr;

 private:
  static std::size_t on_body(char* data, std::size_t, std::size_t size, void* user);
  static std::size_t on_header(char* data, std::size_t, std::size_t size, void* user);
  bool accept_body();
  bool is_range_asked_for() const;
  long status() const;
  std::string transfer_error(int code) const;

  const HttpWanted wanted_;
  const SourceOptions& options_;
  CURL* const handle_;
  void* headers_ = nullptr;
  Bytes body_;
  // Of the attempt.
  std::string range_, content_range_, tag_;
  Time begun_{};
  std::optional<Time> newest_byte_;
  std::uint64_t asked_for_ = 0;  ///< bytes of the body, of a range
  std::uint64_t came_ = 0, discarded_ = 0;
  bool accepted_ = false, wrong_range_ = false, too_long_ = false, unchanged_ = false;
};

}  // namespace pointreel
