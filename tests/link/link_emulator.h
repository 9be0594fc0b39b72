#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "pointreel/error.h"
#include "tests/link/link_script.h"

/// A bad network on loopback for tests and benchmarks: a TCP proxy that needs no privileges.
///
///     auto link = LinkEmulator::start({.target = "127.0.0.1:8090"});
///     (*link)->set({.bits_per_second = 50'000'000, .delay = 10ms});   // 20 ms round trip
///     open_source("http://" + (*link)->address() + "/reel");
///     (*link)->set({.cut = true});       // nothing passes until set({})
///     (*link)->reset_connections();
///     (*link)->run({{5s, "rate 5M"}, {10s, "reset"}, {12s, "cut"}, {15s, "restore"}});
///
/// It models a link with a rate in each direction, which all connections share or each has for
/// itself, a delay, and the round trip for establishing a connection. A byte leaves after those
/// before it have left, and arrives `delay` later. It does not model slow start, loss (which TCP
/// turns into delay), or bottlenecks with large buffers: in each direction it holds no more than
/// the link carries in 5 ms, and up to 64 KiB of each connection wait in its socket.
namespace pointreel {

struct LinkStatistics {
  std::uint64_t up_bytes = 0, down_bytes = 0;  ///< passed on to the target, and from it
  std::uint64_t connections = 0;               ///< since the start
  std::size_t open = 0;                        ///< connections now
  std::uint64_t flipped_bits = 0;
};

class LinkEmulator {
 public:
  struct Options {
    std::string target;              ///< "host:port", looked up at the start
    std::uint16_t port = 0;          ///< to listen on at 127.0.0.1; 0: any free port
    LinkConditions conditions = {};  ///< at the start
    std::uint64_t seed = 1;          ///< for the choice of the bits that are flipped
  };

  /// Starts the link in a thread of its own. It runs until it is destroyed, which resets all
  /// connections.
  static Result<std::unique_ptr<LinkEmulator>> start(const Options& options);
  ~LinkEmulator();
  LinkEmulator(const LinkEmulator&) = delete;
  LinkEmulator& operator=(const LinkEmulator&) = delete;

  std::uint16_t port() const;
  std::string address() const;  ///< "127.0.0.1:PORT"

  // All of these may be called from any thread. They take effect before the next byte leaves.
  void set(const LinkConditions& conditions);
  LinkConditions conditions() const;
  /// Sets the target of new connections, for a server that was restarted at another address.
  Result<void> set_target(const std::string& target);
  /// Resets all open connections. New connections work at once.
  void reset_connections();
  /// Stops all traffic on the open connections without telling either end, like a router that lost
  /// its table. New connections work.
  void forget_connections();
  /// Runs a script from now on, in place of any script that is running. If an event is invalid, the
  /// call fails and changes nothing.
  Result<void> run(const LinkScript& script);
  LinkStatistics statistics() const;

 private:
  class Loop;
  explicit LinkEmulator(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace pointreel
