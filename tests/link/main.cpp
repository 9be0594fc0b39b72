// pointreel-link: a bad network on loopback, for experiments.

#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "common/base/words.h"
#include "common/command_line/command.h"
#include "common/process/print.h"
#include "common/process/standard_output.h"
#include "tests/link/link_emulator.h"

namespace {

constexpr const char* kFooter =
    R"(Each line of a script has a time in seconds since the start and an event:
  0    rate 100M          all connections share 100 Mbit/s in each direction; k, M, G; 0: no limit
  0    delay 10           bytes take 10 milliseconds one way, which is half of the round trip
  5    rate-each 5M       each connection has 5 Mbit/s in each direction for itself
  10   cut                nothing passes any more; open connections stay open
  20   restore            ends the cut
  25   reset              resets all open connections
  26   forget             stops all traffic on the open connections; new connections work
  27   split 1            passes on at most 1 byte at once
  28   corrupt 20000      flips one bit in about 20,000 bytes towards the client
  29   truncate 50000     closes each connection after 50,000 bytes towards the client
  30   reset-after 50000  resets each connection after 50,000 bytes towards the client
  31   clear              makes the link perfect
"#" starts a comment. Example:
  pointreel-link --to 127.0.0.1:8090 --port 8091 --rate 20M --delay 25
  pointreel play http://127.0.0.1:8091/NAME

Exit status: 0 ended by a signal, 1 failure, 2 wrong usage.)";

int report(const pointreel::Error& error) {
  pointreel::print_error("pointreel-link", error.message);
  return 1;
}

}  // namespace

namespace {

int run(int argc, char** argv) {
  pointreel::cli::Program app{
      "Emulates a bad network: a TCP proxy with a limited rate, a delay and faults. It listens on "
      "127.0.0.1, passes connections on to another address, and runs until it is interrupted.",
      "pointreel-link"};
  app.footer(kFooter);
  pointreel::LinkEmulator::Options options;
  std::string rate = "0", script_path;
  double delay = 0.0;
  app.add_option("--to", options.target, "the address to pass connections on to")
      .required()
      .type_name("HOST:PORT");
  app.add_option("--port", options.port, "the port to listen on; 0: any free port")
      .type_name("PORT")
      .capture_default_str();
  app.add_option("--rate", rate, "bits per second in each direction, such as 5M; 0: no limit")
      .type_name("RATE")
      .capture_default_str();
  app.add_option("--delay", delay, "milliseconds one way, which is half of the round trip")
      .check(pointreel::cli::number_within(0.0, 60'000.0))
      .type_name("MS")
      .capture_default_str();
  app.add_option("--script", script_path, "a file of changes over time; see below")
      .type_name("FILE");
  using namespace pointreel;
  app.add_common_options();
  if (const auto status = app.parse(argc, argv)) return *status;

  LinkScript script{{std::chrono::milliseconds(0), "rate " + rate},
                    {std::chrono::milliseconds(0), fmt::format("delay {}", delay)}};
  if (!script_path.empty()) {
    std::ifstream in(script_path, std::ios::binary);
    if (!in) return report({script_path + ": cannot be opened"});
    const std::string text(std::istreambuf_iterator<char>(in), {});
    const auto parsed = parse_link_script(text);
    if (!parsed) return report({script_path + ": " + parsed.error().message});
    script.insert(script.end(), parsed->begin(), parsed->end());
  }

  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto link = LinkEmulator::start(options);
  if (!link) return report(link.error());
  if (const auto running = (*link)->run(script); !running) return report(running.error());
  print("listening on {}\n", (*link)->address());
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
  const LinkStatistics statistics = (*link)->statistics();
  print("{}, {} up, {} down, {} flipped\n", counted(statistics.connections, "connection"),
        counted(statistics.up_bytes, "byte"), counted(statistics.down_bytes, "byte"),
        counted(statistics.flipped_bits, "bit"));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return pointreel::finish_output("pointreel-link", run(argc, argv));
}
