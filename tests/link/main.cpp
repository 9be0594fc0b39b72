// pointreel-link: a bad network on loopback, for trying things by hand.

#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tests/link/link_emulator.h"

namespace {

constexpr const char* kScripts = R"(
A script has lines of a time in seconds since the start and what happens then:
  0    rate 100M       bits per second in each direction; k, M, G; 0: no limit
  0    delay 10        milliseconds one way: half the round trip
  5    rate-each 5M    the same for each connection by itself
  10   cut             nothing passes, until
  20   restore
  25   reset           all connections; "reset-after 50000": each after so many bytes
  26   forget          nothing passes over the connections of now any more
  27   split 1         at most so many bytes at once
  28   corrupt 20000   about one bit of so many bytes is flipped, towards the client
  29   truncate 50000  connections end after so many bytes towards the client
  30   clear           a perfect link
"#" begins a comment. Exit codes: 0 ended by a signal, 1 failed, 2 wrong usage.)";

int say(const pointreel::Error& error) {
  fmt::print(stderr, "pointreel-link: {}\n", error.message);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"A bad network on loopback: a TCP proxy with a rate, a delay and faults"};
  app.footer(kScripts);
  pointreel::LinkEmulator::Options options;
  std::string rate = "0", script_path;
  double delay = 0.0;
  app.add_option("--to", options.target, "HOST:PORT that connections lead to")->required();
  app.add_option("--port", options.port, "listened on at 127.0.0.1; 0: any")->capture_default_str();
  app.add_option("--rate", rate, "bits per second in each direction, as in 5M; 0: no limit")
      ->capture_default_str();
  app.add_option("--delay", delay, "milliseconds one way")->capture_default_str();
  app.add_option("--script", script_path, "file of what happens when");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  using namespace pointreel;
  LinkScript script{{std::chrono::milliseconds(0), "rate " + rate},
                    {std::chrono::milliseconds(0), fmt::format("delay {}", delay)}};
  if (!script_path.empty()) {
    std::ifstream in(script_path, std::ios::binary);
    if (!in) return say({script_path + ": cannot be opened"});
    const std::string text(std::istreambuf_iterator<char>(in), {});
    const auto parsed = parse_link_script(text);
    if (!parsed) return say({script_path + ": " + parsed.error().message});
    script.insert(script.end(), parsed->begin(), parsed->end());
  }

  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto link = LinkEmulator::start(options);
  if (!link) return say(link.error());
  if (const auto running = (*link)->run(script); !running) return say(running.error());
  fmt::print("listening on {}\n", (*link)->address());
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
  const LinkStatistics statistics = (*link)->statistics();
  fmt::print("{} connections, {} bytes up, {} bytes down, {} bits flipped\n",
             statistics.connections, statistics.up_bytes, statistics.down_bytes,
             statistics.flipped_bits);
  return 0;
}
