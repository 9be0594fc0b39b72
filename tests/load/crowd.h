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

#include "common/net/url.h"
#include "pointreel/error.h"

namespace pointreel {

using LoadClock = std::chrono::steady_clock;

/// One connection of a crowd.
class CrowdMember {
 public:
  virtual ~CrowdMember();

  /// The host must be an IPv4 address in digits: a name would be looked up for each viewer.
  Result<void> connect(const Url& url);
  int socket() const { return socket_; }
  bool broken() const { return broken_; }
  std::uint64_t bytes() const { return bytes_; }

  /// Reads and handles everything that has arrived.
  void read();
  /// Called at the time that the member asked for; returns the time for the next call.
  virtual LoadClock::time_point on_due(LoadClock::time_point now);

 protected:
  /// Takes what it can use from the front of `buffer()`. Returns false if the peer breaks the
  /// protocol.
  virtual bool on_data() = 0;
  /// Skips the next `size` bytes without storing those that have not arrived yet. `on_skipped` is
  /// called once they have arrived, unless all of them are in the buffer already.
  void skip(std::uint64_t size);
  virtual bool on_skipped() { return true; }

  std::string_view buffer() const { return std::string_view(buffer_).substr(taken_); }
  void take(std::size_t size) { taken_ += size; }
  /// Sends a text that must be small enough for the socket to accept it at once.
  void send(std::string_view text);
  void break_off();

 private:
  bool use(std::size_t arrived);

  int socket_ = -1;
  bool broken_ = false;
  std::uint64_t bytes_ = 0, skip_ = 0;
  std::string buffer_;
  std::size_t taken_ = 0;
};

/// Serves the members until `end`: calls `read` for those whose sockets are readable and `on_due`
/// for those whose time has come. Calls `begin_measuring` once, at `measured_from`.
void run_crowd(const std::vector<std::unique_ptr<CrowdMember>>& members,
               LoadClock::time_point first_due, LoadClock::time_point end,
               const std::function<void()>& begin_measuring, LoadClock::time_point measured_from);

}  // namespace pointreel
