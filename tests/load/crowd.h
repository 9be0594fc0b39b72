#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <queue>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

using LoadClock = std::chrono::steady_clock;

/// "http://127.0.0.1:80/a" in its parts; an error if the host is no address in digits.
struct LoadUrl {
  std::string scheme, host, target;
  std::uint16_t port = 0;
};
Result<LoadUrl> parse_load_url(const std::string& url);

/// One connection of a crowd.
class CrowdMember {
 public:
  virtual ~CrowdMember();

  Result<void> connect(const LoadUrl& url);
  int socket() const { return socket_; }
  bool broken() const { return broken_; }
  std::uint64_t bytes() const { return bytes_; }

  /// All that has come.
  void read();
  /// Its time has come; when it wants to be called next.
  virtual LoadClock::time_point on_due(LoadClock::time_point now);

 protected:
  /// Takes from the front of `buffer()` what it can use; false: the peer makes no sense.
  virtual bool on_data() = 0;
  /// The next bytes, beyond those in the buffer, are of no interest; `on_skipped` follows.
  void skip(std::uint64_t size);
  virtual bool on_skipped() { return true; }

  std::string_view buffer() const { return std::string_view(buffer_).substr(taken_); }
  void take(std::size_t size) { taken_ += size; }
  /// Small enough for the socket to take it at once.
  void send(std::string_view text);
  void break_off();

 private:
  bool use(std::size_t came);

  int socket_ = -1;
  bool broken_ = false;
  std::uint64_t bytes_ = 0, skip_ = 0;
  std::string buffer_;
  std::size_t taken_ = 0;
};

/// Calls members whose sockets have something, or whose time has come, until `end`.
void run_crowd(const std::vector<std::unique_ptr<CrowdMember>>& members,
               LoadClock::time_point first_due, LoadClock::time_point end,
               const std::function<void()>& begin_measuring, LoadClock::time_point measured_from);

}  // namespace pointreel
