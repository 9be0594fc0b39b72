#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "pointreel/error.h"
#include "tests/link/link_script.h"

/// A bad network on loopback, for tests and benchmarks: a TCP proxy that needs no privileges.
///
///     auto link = LinkEmulator::start({.target = "127.0.0.1:8090"});
///     (*link)->set({.bits_per_second = 50'000'000, .delay = 10ms});   // 20 ms round trip
///     open_source("http://" + (*link)->address() + "/reel");
///     (*link)->set({.cut = true});       // nothing passes until set({})
///     (*link)->reset_connections();
///     (*link)->run({{5s, "rate 5M"}, {10s, "reset"}, {12s, "cut"}, {15s, "restore"}});
///
/// What it models: one link with a rate in each direction that all connections share (or each has
/// for itself), a delay, and the round trip of a connection's making. A byte leaves when those
/// before it have left and comes `delay` later. What it does not: slow start, loss (to TCP loss is
/// delay) and bottlenecks with large buffers: of either side's bytes it holds no more than the link
/// carries in 5 ms, and 64 KiB of a connection wait in its socket.
namespace pointreel {

struct LinkStatistics {
  std::uint64_t up_bytes = 0, down_bytes = 0;  ///< handed on to the target, and from it
  std::uint64_t connections = 0;               ///< that were ever made to it
  std::size_t open = 0;
  std::uint64_t flipped_bits = 0;
};

class LinkEmulator {
 public:
  struct Options {
    std::string target;              ///< "host:port"; looked up when it starts
    std::uint16_t port = 0;          ///< listened on at 127.0.0.1; 0: any that is free
    LinkConditions conditions = {};  ///< at first
    std::uint64_t seed = 1;          ///< of the bits that are flipped
  };

  /// Runs in a thread of its own until it is destroyed, which resets all connections.
  static Result<std::unique_ptr<LinkEmulator>> start(const Options& options);
  ~LinkEmulator();
  LinkEmulator(const LinkEmulator&) = delete;
  LinkEmulator& operator=(const LinkEmulator&) = delete;

  std::uint16_t port() const;
  std::string address() const;  ///< "127.0.0.1:PORT"

  // From any thread; they take effect before the next byte leaves.
  void set(const LinkConditions& conditions);
  LinkConditions conditions() const;
  /// Where connections lead from now on: for a server that was started again elsewhere.
  Result<void> set_target(const std::string& target);
  /// Resets all connections; new ones may be made at once.
  void reset_connections();
  /// Nothing passes over the connections of now any more, nor is either end told: as after a
  /// router that lost its table. New ones work.
  void forget_connections();
  /// Lets the events happen, counted from now; replaces a script that runs. An event that is none
  /// is an error, and nothing happens.
  Result<void> run(const LinkScript& script);
  LinkStatistics statistics() const;

 private:
  class Loop;
  explicit LinkEmulator(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace pointreel
