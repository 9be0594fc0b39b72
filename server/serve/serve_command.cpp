#include "server/serve/serve_command.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <sys/resource.h>

#include "server/relay/relay.h"
#include "server/serve/catalog.h"
#include "server/serve/http_server.h"
#include "server/serve/live_sinks.h"

namespace pointreel {
namespace {

struct ServeArguments {
  std::vector<std::string> reels;
  std::string listen = "127.0.0.1:8090";
  HttpServerOptions options;
  double header_seconds = 10, idle_seconds = 60, stall_seconds = 30;
  bool live = false;
  std::string record;
  std::string log = "warning";
};

std::chrono::milliseconds from_seconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000.0));
}

/// Each connection may need its socket and one file. The usual soft limit, 1024, is below that.
void allow_open_files(std::size_t connections) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t wanted = 2 * static_cast<rlim_t>(connections) + 128;
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < wanted) {
    limit.rlim_cur = std::min(wanted, limit.rlim_max);
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
}

Result<void> serve(const ServeArguments& arguments) {
  HttpServerOptions options = arguments.options;
  options.header_timeout = from_seconds(arguments.header_seconds);
  options.idle_timeout = from_seconds(arguments.idle_seconds);
  options.stall_timeout = from_seconds(arguments.stall_seconds);
  const auto listen = parse_listen_address(arguments.listen);
  if (!listen) return tl::unexpected(listen.error());
  options.listen = *listen;
  if (arguments.reels.empty() && !arguments.live) {
    return fail("there is nothing to serve; name packages, or give --live");
  }
  const auto level = parse_log_level(arguments.log);
  if (!level) return tl::unexpected(level.error());
  options.service.log = *level;
  auto catalog = Catalog::load({arguments.reels.begin(), arguments.reels.end()});
  if (!catalog) return tl::unexpected(catalog.error());
  allow_open_files(options.max_connections);

  // Blocked before the server's threads begin, so that only this one takes them. A shell may have
  // had SIGINT ignored for what runs in its background.
  sigset_t ending;
  sigemptyset(&ending);
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, SIG_DFL);
    sigaddset(&ending, signal);
  }
  ::pthread_sigmask(SIG_BLOCK, &ending, nullptr);
  std::signal(SIGPIPE, SIG_IGN);

  Log log(*level);
  RelayOptions relay_options;
  if (arguments.live) {
    const auto resources = std::make_shared<LiveResources>();
    catalog->add(resources);
    std::optional<std::filesystem::path> record;
    if (!arguments.record.empty()) record = arguments.record;
    relay_options.sinks = live_sinks(resources, record, [&log](const std::string& line) {
      log.write(Log::Level::kWarning, "recording", {{"what", line}});
    });
  }
  Relay relay(std::move(relay_options));
  const auto server =
      HttpServer::start(*std::move(catalog), options, arguments.live ? &relay : nullptr);
  if (!server) return tl::unexpected(server.error());
  fmt::print("listening on {}://{}\n", options.certificate.empty() ? "http" : "https",
             to_string((*server)->address()));
  std::fflush(stdout);
  int signal = 0;
  ::sigwait(&ending, &signal);
  (*server)->stop();
  return {};
}

}  // namespace

void add_serve_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<ServeArguments>();
  CLI::App* command = app.add_subcommand(
      "serve",
      "Serve packages and live streams over HTTP until SIGINT or SIGTERM\n"
      "Each package is at /NAME, its folder's name; GET / lists them, GET /healthz says ok, GET\n"
      "/metrics is for Prometheus. Live streams are at /live/NAME, a WebSocket.\n"
      "--config FILE takes options from a file: a line [serve], then lines NAME = VALUE.");
  app.set_config("--config", "",
                 "Take a command's options from FILE: [COMMAND], NAME = VALUE (TOML)")
      ->type_name("FILE");
  // What is misspelt there is an error, as it is on the command line.
  app.allow_config_extras(CLI::config_extras_mode::error);
  command->allow_config_extras(CLI::config_extras_mode::error);
  command->fallthrough();
  command->add_option("reels", arguments->reels, "Package folders")->type_name("REEL");
  command
      ->add_option("--listen", arguments->listen,
                   "Address and port; port 0 takes a free one, 0.0.0.0 all of this machine's "
                   "addresses")
      ->type_name("ADDRESS:PORT")
      ->capture_default_str();
  command
      ->add_option("--max-connections", arguments->options.max_connections,
                   "Connections at a time; for one more an idle one goes, or it gets 503")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--max-connections-per-address", arguments->options.max_connections_per_address,
                   "Of these, of one address; all who come through one proxy have one")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--max-requests", arguments->options.requests_per_second,
                   "Requests a second of one address, beyond which 429 is answered; 0: any number")
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("RATE")
      ->capture_default_str();
  CLI::Option* live = command->add_flag(
      "--live", arguments->live, "Relay live streams, too: pointreel-server publish sends them");
  command
      ->add_option("--record", arguments->record,
                   "Record live streams as packages in this folder, NAME, NAME-2, ...")
      ->type_name("FOLDER")
      ->needs(live);
  command
      ->add_option("--view-token", arguments->options.service.view_token,
                   "Who asks for anything must show it: Authorization: Bearer TOKEN")
      ->type_name("TOKEN")
      ->envname("POINTREEL_VIEW_TOKEN");
  command
      ->add_option("--publish-token", arguments->options.service.publish_token,
                   "Who publishes must show it; without one, only this machine may publish")
      ->type_name("TOKEN")
      ->envname("POINTREEL_PUBLISH_TOKEN");
  command
      ->add_option("--log", arguments->log,
                   "What to write on standard error, as JSON lines: debug, info (every request), "
                   "warning, error or off")
      ->type_name("LEVEL")
      ->capture_default_str();
  command
      ->add_option("--max-message", arguments->options.max_message,
                   "Bytes of a publisher's message; 4M is 4 MiB")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Range(kMaxLiveText, kLiveHeaderSize + kMaxLiveLayer))
      ->capture_default_str();
  command
      ->add_option("--publish-rate", arguments->options.publish_rate,
                   "Bytes a second of a publisher, who is held back beyond it; 0: any")
      ->check(CLI::Range(0.0, 1e12))
      ->type_name("BYTES")
      ->capture_default_str();
  command->add_option("--threads", arguments->options.threads, "0: one for each processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  const auto add_seconds = [command](const char* name, double& value, const char* what) {
    command->add_option(name, value, what)
        ->check(CLI::Range(0.1, 86400.0))
        ->type_name("SECONDS")
        ->capture_default_str();
  };
  CLI::Option* certificate =
      command
          ->add_option("--certificate", arguments->options.certificate,
                       "Serve over TLS: the certificate and those that signed it, in PEM form")
          ->type_name("FILE");
  command->add_option("--key", arguments->options.key, "The certificate's key, without password")
      ->type_name("FILE")
      ->needs(certificate);
  certificate->needs("--key");
  add_seconds("--header-timeout", arguments->header_seconds, "For the head of one request");
  add_seconds("--idle-timeout", arguments->idle_seconds, "Between requests of a connection");
  add_seconds("--stall-timeout", arguments->stall_seconds, "Without the reader taking a byte");
  command->callback([arguments, &exit_code] {
    const auto served = serve(*arguments);
    if (served) return;
    fmt::print(stderr, "pointreel-server: {}\n", served.error().message);
    exit_code = 1;
  });
}

}  // namespace pointreel
