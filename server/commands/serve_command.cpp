#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include "common/base/try.h"
#include "common/command_line/token_option.h"
#include "common/net/server_tokens.h"
#include "common/net/url.h"
#include "common/process/print.h"
#include "common/threads/run_detached.h"
#include "server/commands/commands.h"
#include "server/relay/relay.h"
#include "server/serve/http_server.h"
#include "server/serve/live_sinks.h"
#include "server/service/catalog.h"
#include "server/service/request_target.h"
#include "server/upstream/upstream.h"

namespace pointreel {
namespace {

struct ServeArguments {
  std::vector<std::filesystem::path> reels;
  HttpServerOptions options;
  std::string listen = to_string(options.listen);
  std::string log = name(options.service.log);
  std::span<const PageFile> page;
  bool live = false, no_page = false;
  std::filesystem::path record;
  std::vector<std::string> origins, embedders;
  double grace = 10.0;  ///< seconds
  std::vector<std::string> relay_from;
  std::string relay_token, relay_ca;
  std::filesystem::path relay_token_file;
  cli::Option view_token, publish_token, relay_token_option;
};

/// Each connection may need its socket and one file, but the usual soft limit is 1024 descriptors.
void allow_open_files(std::size_t connections) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t wanted = 2 * static_cast<rlim_t>(connections) + 128;
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < wanted) {
    limit.rlim_cur = std::min(wanted, limit.rlim_max);
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
}

/// Prints a line to standard output. Whoever reads it may have stopped reading, which must keep the
/// server neither from serving nor from ending.
void announce(std::string line) {
  run_detached([line = std::move(line)] {
    if (::write(STDOUT_FILENO, line.data(), line.size()) < 0) return;  // nobody wants to know
  });
}

/// The options that the command line may not give in this combination.
Result<HttpServerOptions> options_of(const ServeArguments& arguments) {
  HttpServerOptions options = arguments.options;
  options.listen = TRY(parse_listen_address(arguments.listen));
  options.service.log = TRY(parse_log_level(arguments.log));
  for (const cli::Option token :
       {arguments.view_token, arguments.publish_token, arguments.relay_token_option}) {
    if (std::string fault = fault_of_token(token); !fault.empty()) {
      return fail(ErrorCode::argument, std::move(fault));
    }
  }
  const std::string frame_ancestors = TRY(parse_frame_ancestors(arguments.embedders));
  if (!arguments.no_page) options.service.page = Page(arguments.page, frame_ancestors);
  options.service.origins = TRY(Origins::parse(arguments.origins));
  // A server that relays others needs no publishers of its own.
  if (arguments.live && arguments.relay_from.empty() && options.service.publish_token.empty() &&
      !is_loopback(options.listen) && !options.service.allow_local_publish) {
    return fail(ErrorCode::argument,
                fmt::format("--live on {} needs --publish-token, or else nobody may publish; with "
                            "--allow-local-publish programs on this machine may, and everybody for "
                            "whom a proxy on this machine connects",
                            arguments.listen));
  }
  if (std::min(options.max_unfinished, options.max_unfinished_per_address) < options.max_message) {
    return fail(ErrorCode::argument,
                "--max-unfinished and --max-unfinished-per-address must not be less than "
                "--max-message");
  }
  return options;
}

/// Begins to pass on the streams of other servers.
Result<std::vector<std::unique_ptr<Upstream>>> follow(const ServeArguments& arguments,
                                                      const HttpServerOptions& server, Relay& relay,
                                                      Log& log) {
  ServerTokens tokens;
  if (!arguments.relay_token_file.empty())
    tokens = TRY(at_place("--relay-token-file", ServerTokens::read(arguments.relay_token_file)));
  std::vector<UpstreamOptions> all;
  for (const std::string& text : arguments.relay_from) {
    UpstreamOptions options = TRY(at_place("--relay-from", parse_upstream(text)));
    const std::string* own = tokens.of(options.url);
    options.token = own != nullptr ? *own : arguments.relay_token;
    if (options.token.empty() && !arguments.relay_token_file.empty())
      log.write(Log::Level::kWarning, "relay",
                {{"what", fmt::format("{}: has no line for {}", arguments.relay_token_file.string(),
                                      without_secrets(options.url))}});
    options.ca_file = arguments.relay_ca;
    options.max_message = server.max_message;
    options.text_rate = server.publish_text_rate;
    options.say = [&log](const std::string& line) {
      log.write(Log::Level::kWarning, "relay", {{"what", line}});
    };
    all.push_back(std::move(options));
  }
  std::vector<std::unique_ptr<Upstream>> upstreams;
  for (UpstreamOptions& options : all)
    upstreams.push_back(TRY(Upstream::start(relay, std::move(options))));
  return upstreams;
}

/// What serve prints once it listens.
std::string announcement(const std::vector<PackageFolder>& reels, bool live,
                         const HttpServerOptions& options, const ListenAddress& address) {
  const std::string scheme = options.certificate.empty() ? "http" : "https";
  std::string text = fmt::format("listening on {}://{}\n", scheme, to_string(address));
  if (options.service.page.empty()) return text;
  std::string link = fmt::format("{}://{}/", scheme, to_string(reachable_address(address)));
  if (reels.size() == 1 && !live) {
    link += encode_path(reels.front().name).substr(1);
  }
  const bool guarded = !options.service.view_token.empty();
  return text + fmt::format("open {}{} in a browser to play\n", link,
                            guarded ? "#token=TOKEN, with the view token," : "");
}

/// Reads again what may change while the server runs.
class Rereading {
 public:
  Rereading(ServeArguments arguments, std::vector<std::string> command_line, Catalog catalog,
            HttpServer& server, Log& log)
      : arguments_(std::move(arguments)),
        listen_(arguments_.listen),
        command_line_(std::move(command_line)),
        catalog_(std::move(catalog)),
        server_(server),
        log_(log) {
    certificate_changed();
  }

  /// The packages, and the certificate if it has changed.
  void look() {
    const Catalog::News news = catalog_.refresh(arguments_.reels);
    for (const std::string& line : news.changes)
      log_.write(Log::Level::kInfo, "packages", {{"what", line}});
    for (const std::string& line : news.faults)
      log_.write(Log::Level::kWarning, "packages", {{"what", line}});
    if (certificate_changed()) read_certificate();
  }

  /// The command line and its configuration file: packages, tokens and the certificate.
  void read_again() {
    auto arguments = parse_again(command_line_);
    if (!arguments) {
      log_.write(Log::Level::kError, "reread", {{"fault", arguments.error().message}});
      return;
    }
    // So that a file which is just being written opens nothing to everybody.
    const ServiceOptions &old = arguments_.options.service, &service = arguments->options.service;
    if ((!old.view_token.empty() && service.view_token.empty()) ||
        (!old.publish_token.empty() && service.publish_token.empty())) {
      log_.write(
          Log::Level::kError, "reread",
          {{"fault", "a token is missing, so nothing changes; restart to serve without it"}});
      return;
    }
    if (arguments->listen != listen_)
      log_.write(Log::Level::kWarning, "reread",
                 {{"what", "restart to listen on " + arguments->listen}});
    server_.set_tokens(service.view_token, service.publish_token);
    arguments_ = *std::move(arguments);
    certificate_changed();
    read_certificate();
    log_.write(Log::Level::kInfo, "reread");
  }

 private:
  /// Only what may be given.
  static Result<ServeArguments> parse_again(const std::vector<std::string>& command_line);

  bool certificate_changed() {
    const auto time = [](const std::filesystem::path& file) {
      std::error_code error;
      const auto written = std::filesystem::last_write_time(file, error);
      return error ? std::filesystem::file_time_type() : written;
    };
    const std::pair times(time(arguments_.options.certificate), time(arguments_.options.key));
    return std::exchange(certificate_times_, times) != times;
  }

  void read_certificate() {
    const auto& options = arguments_.options;
    if (const auto read = server_.read_certificate(options.certificate, options.key); !read) {
      log_.write(Log::Level::kError, "certificate",
                 {{"fault", read.error().message + "; the one before stays in use"}});
    } else if (!options.certificate.empty()) {
      log_.write(Log::Level::kInfo, "certificate", {{"what", "read again"}});
    }
  }

  ServeArguments arguments_;
  const std::string listen_;  ///< the address until the end of the program
  const std::vector<std::string> command_line_;
  Catalog catalog_;
  HttpServer& server_;
  Log& log_;
  std::pair<std::filesystem::file_time_type, std::filesystem::file_time_type> certificate_times_;
};

/// Waits for a signal to end, and looks meanwhile for what has changed: once a second, and less
/// often if that takes more than a twentieth of the time.
/// `outlives_terminal`: it was started by nohup or the like.
void run_until_signal(Rereading& reading, const sigset_t& signals, bool outlives_terminal) {
  using namespace std::chrono_literals;
  std::chrono::nanoseconds pause = 1s;
  for (;;) {
    const timespec wait{pause.count() / 1'000'000'000, pause.count() % 1'000'000'000};
    siginfo_t info{};
    const int signal = ::sigtimedwait(&signals, &info, &wait);
    // The system itself says that the terminal has gone.
    const bool terminal_gone = signal == SIGHUP && info.si_code == SI_KERNEL;
    if (signal == SIGINT || signal == SIGTERM || (terminal_gone && !outlives_terminal)) return;
    const auto begin = std::chrono::steady_clock::now();
    if (signal == SIGHUP) reading.read_again();
    reading.look();
    pause = std::clamp<std::chrono::nanoseconds>(20 * (std::chrono::steady_clock::now() - begin),
                                                 1s, 60s);
  }
}

Result<void> serve(const ServeArguments& arguments, const std::vector<std::string>& command_line) {
  if (arguments.reels.empty() && !arguments.live) {
    return fail(ErrorCode::argument, "there is nothing to serve; name packages, or use --live");
  }
  const HttpServerOptions options = TRY(options_of(arguments));
  // What is served may be what is recorded, from the first time on.
  if (std::error_code error; !arguments.record.empty()) {
    std::filesystem::create_directories(arguments.record, error);
    const auto folder = arguments.record.c_str();
    if (!error && ::faccessat(AT_FDCWD, folder, W_OK | X_OK, AT_EACCESS) != 0)
      error.assign(errno, std::generic_category());
    if (error)
      return fail(ErrorCode::io,
                  fmt::format("--record {}: {}", arguments.record.string(), error.message()));
  }
  const std::vector<PackageFolder> reels = TRY(packages_in(arguments.reels));
  Catalog catalog = TRY(Catalog::load(arguments.reels));
  allow_open_files(options.max_connections);

  // Signals are blocked before the server starts its threads, so that only this thread gets them.
  // Shells start programs in the background with SIGINT ignored.
  sigset_t signals;
  sigemptyset(&signals);
  const bool outlives_terminal = std::signal(SIGHUP, SIG_DFL) == SIG_IGN;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    std::signal(signal, SIG_DFL);
    sigaddset(&signals, signal);
  }
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a recording that may not grow is an error like a full disk

  Log log(options.service.log);
  RelayOptions relay_options;
  relay_options.grace =
      std::chrono::milliseconds(static_cast<std::int64_t>(arguments.grace * 1000.0));
  if (arguments.live) {
    const auto resources = std::make_shared<LiveResources>();
    catalog.add(resources);
    relay_options.sinks = live_sinks(resources, arguments.record, [&log](const std::string& line) {
      log.write(Log::Level::kWarning, "recording", {{"what", line}});
    });
  }
  Relay relay(std::move(relay_options));
  const std::unique_ptr<HttpServer> server =
      TRY(HttpServer::start(catalog, options, arguments.live ? &relay : nullptr));
  const auto upstreams = TRY(follow(arguments, options, relay, log));
  announce(announcement(reels, arguments.live, options, server->address()));
  Rereading reading(arguments, command_line, std::move(catalog), *server, log);
  reading.look();  // tells the faults of packages
  run_until_signal(reading, signals, outlives_terminal);
  server->stop();
  return {};
}

}  // namespace

namespace {

/// Adds the command and its options, which write to `arguments`. `again`: while the server runs,
/// and must not wait for whoever might write to a pipe.
cli::Command define_serve(cli::Command app, const std::shared_ptr<ServeArguments>& arguments,
                          bool again) {
  HttpServerOptions& options = arguments->options;
  const cli::Command command = app.add_subcommand(
      "serve",
      "Serve packages and live streams over HTTP until SIGINT or SIGTERM\n"
      "The package in folder NAME is served at /NAME. GET / lists all packages, /healthz answers "
      "ok, and /metrics is for Prometheus. Live streams are at /live/NAME, over WebSocket or "
      "HTTP.\n"
      "--config FILE reads options from a file: a line [serve], then lines NAME = VALUE. On SIGHUP "
      "the command line and this file are read again: packages, the view and publish tokens, and "
      "the certificate; tokens for relaying are read only at the start. Packages in a folder are "
      "found while it is served.");
  const cli::Option config = command
                                 .add_config("--config",
                                             "Read the options of serve from FILE (TOML): a "
                                             "line [serve], then lines NAME = VALUE")
                                 .type_name("FILE");
  if (again) {
    config.check({[](const std::string& file) -> std::string {
      std::error_code error;
      const bool is_file = std::filesystem::is_regular_file(file, error);
      return is_file ? "" : file + " is not a file that can be read again";
    }});
  }
  command
      .add_option("reels", arguments->reels,
                  "the folders of packages; a folder that holds packages stands for all of them")
      .type_name("REEL");
  command
      .add_option("--listen", arguments->listen,
                  "where to listen; port 0 takes a free port, and 0.0.0.0 means all addresses of "
                  "this machine")
      .type_name("ADDRESS:PORT")
      .capture_default_str();
  command
      .add_option("--max-connections", options.max_connections,
                  "connections at a time; a further one replaces an idle one, or gets 503")
      .check(cli::range(1, 1'000'000))
      .capture_default_str();
  command
      .add_option("--max-connections-per-address", options.max_connections_per_address,
                  "connections at a time from one address; clients behind a proxy share its "
                  "address")
      .check(cli::range(1, 1'000'000))
      .capture_default_str();
  command
      .add_option("--max-requests", options.requests_per_second,
                  "requests per second from one address; further ones get 429; 0: unlimited")
      .check(cli::number_within(0.0, 1e9))
      .type_name("RATE")
      .capture_default_str();
  const cli::Option live = command.add_flag(
      "--live", arguments->live, "also relay live streams, which pointreel-server publish sends");
  command
      .add_option("--record", arguments->record,
                  "record live streams as packages NAME, NAME-2, ... in this folder")
      .check(cli::not_empty("a folder"))
      .type_name("FOLDER")
      .needs(live);
  command
      .add_option("--relay-from", arguments->relay_from,
                  "also relay the live streams of another server, ws(s)://HOST/live, or one of "
                  "them, ws(s)://HOST/live/NAME; NAME=URL renames them: * in NAME stands for the "
                  "name on that server, as in 'paris-*=ws://HOST/live'; may be repeated")
      .type_name("[NAME=]URL")
      .allow_extra_args(false)
      .needs(live);
  arguments->relay_token_option =
      command
          .add_option("--relay-token", arguments->relay_token,
                      "the view token of the servers named by --relay-from")
          .type_name("TOKEN")
          .envname("POINTREEL_RELAY_TOKEN");
  command
      .add_option("--relay-token-file", arguments->relay_token_file,
                  "a file with a view token for each server that --relay-from names: lines of "
                  "ws(s)://HOST[:PORT], blanks and the token. A token is sent to its own server "
                  "only; servers without a line get --relay-token")
      .type_name("FILE");
  command
      .add_option("--relay-ca-file", arguments->relay_ca,
                  "for wss: trust the certificates in this PEM file instead of the system's")
      .type_name("FILE");
  arguments->view_token =
      command
          .add_option("--view-token", options.service.view_token,
                      "serve only requests with this token: Authorization: Bearer TOKEN")
          .type_name("TOKEN")
          .envname("POINTREEL_VIEW_TOKEN");
  arguments->publish_token =
      command
          .add_option("--publish-token", options.service.publish_token,
                      "accept only publishers with this token; without one, only programs on this "
                      "machine may publish, and only if the server listens on loopback alone")
          .type_name("TOKEN")
          .envname("POINTREEL_PUBLISH_TOKEN");
  command.add_flag("--allow-local-publish", options.service.allow_local_publish,
                   "without a publish token, let connections from this machine publish although "
                   "the server listens on other addresses too; do not use it behind a proxy on "
                   "this machine, because all its clients then look local");
  command
      .add_option("--allow-origin", arguments->origins,
                  "let pages of this origin, such as https://example.org, read what the server "
                  "answers and connect to live streams; * for all pages; may be repeated")
      .type_name("ORIGIN")
      .allow_extra_args(false);
  command
      .add_option("--embed-in", arguments->embedders,
                  "let pages of this origin show the page of this server in a frame; * for all "
                  "pages; may be repeated")
      .type_name("ORIGIN")
      .allow_extra_args(false);
  command.add_flag(
      "--no-page", arguments->no_page,
      "give browsers JSON and redirects, as other programs get, instead of the page that plays");
  command
      .add_option("--log", arguments->log,
                  "what to write to standard error, as JSON lines: debug, info (each request), "
                  "warning, error or off")
      .type_name("LEVEL")
      .capture_default_str();
  command
      .add_option("--max-message", options.max_message,
                  "size of the largest message that a publisher may send; 4M means 4 MiB")
      .in_bytes()
      .check(cli::range(kMaxLiveText, kLiveHeaderSize + kMaxLiveLayer))
      .capture_default_str();
  command
      .add_option(
          "--publish-rate", options.publish_rate,
          "bytes per second that a publisher may send before it is slowed down; 0: unlimited")
      .check(cli::number_within(0.0, 1e12))
      .type_name("BYTES")
      .capture_default_str();
  command
      .add_option("--least-rate", options.least_rate,
                  "lowest average rate, in bytes per second, of a publisher's message once it has "
                  "begun, after five seconds of grace; 0: no limit")
      .check(cli::number_within(0.0, 1e9))
      .type_name("BYTES")
      .capture_default_str();
  const auto add_count = [command](const char* flag, std::size_t& value, const char* description) {
    command.add_option(flag, value, description)
        .check(cli::range(1, 1'000'000))
        .capture_default_str();
  };
  add_count("--max-hellos", options.max_hellos,
            "publishers at a time that have connected but not yet sent their hello; further ones "
            "get 503");
  add_count("--max-hellos-per-address", options.max_hellos_per_address,
            "as --max-hellos, for publishers from one address");
  const auto add_size = [command](const char* flag, std::size_t& value, const char* description) {
    command.add_option(flag, value, description)
        .in_bytes()
        .check(cli::range(kMaxLiveText, std::size_t{1} << 40))
        .capture_default_str();
  };
  add_size(
      "--max-unfinished", options.max_unfinished,
      "bytes of publishers' messages that have begun and are not complete; the publisher whose "
      "message exceeds this is disconnected");
  add_size("--max-unfinished-per-address", options.max_unfinished_per_address,
           "as --max-unfinished, for publishers from one address");
  command
      .add_option("--publisher-grace", arguments->grace,
                  "for how long a stream's name is kept for a publisher that has lost its "
                  "connection")
      .check(cli::number_within(0.0, 86400.0))
      .type_name("SECONDS")
      .capture_default_str();
  command.add_option("--threads", options.threads, "threads that serve; 0: one for each processor")
      .check(cli::range(0, 1024))
      .capture_default_str();
  const cli::Option certificate =
      command
          .add_option("--certificate", options.certificate,
                      "serve over TLS: the certificate and those that signed it, in PEM form")
          .type_name("FILE");
  const cli::Option key =
      command
          .add_option("--key", options.key,
                      "the key of the certificate in PEM form, without a password")
          .type_name("FILE")
          .needs(certificate);
  certificate.needs(key);
  const auto add_seconds = [command](const char* flag, std::chrono::milliseconds& value,
                                     const char* description) {
    const auto set = [&value](double seconds) {
      value = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000.0));
    };
    command.add_option_function<double>(flag, set, description)
        .check(cli::number_within(0.1, 86400.0))
        .type_name("SECONDS")
        .default_str(fmt::format("{:g}", std::chrono::duration<double>(value).count()));
  };
  add_seconds("--header-timeout", options.header_timeout,
              "close a connection if the head of a request, or the hello of a publisher, takes "
              "longer than this");
  add_seconds("--idle-timeout", options.idle_timeout,
              "close a connection on which no request comes for this time");
  add_seconds("--stall-timeout", options.stall_timeout,
              "close a connection if the peer accepts no byte of a response for this time");
  command.essentials({"--listen", "--live", "--record", "--relay-from", "--view-token",
                      "--publish-token", "--allow-origin", "--embed-in", "--certificate", "--key",
                      "--log"});
  return command;
}

Result<ServeArguments> Rereading::parse_again(const std::vector<std::string>& command_line) {
  cli::Program app;
  app.add_common_options();
  const auto arguments = std::make_shared<ServeArguments>();
  define_serve(app, arguments, true);
  TRY(app.parse(command_line));
  TRY(options_of(*arguments));  // while their options exist
  return *arguments;
}

}  // namespace

void add_serve_command(cli::Command app, int& exit_code, std::vector<std::string> command_line,
                       std::span<const PageFile> page) {
  const auto arguments = std::make_shared<ServeArguments>();
  arguments->page = page;
  const cli::Command command = define_serve(app, arguments, false);
  command.callback([arguments, &exit_code, command_line = std::move(command_line)] {
    const auto served = serve(*arguments, command_line);
    if (served) return;
    print_error(served.error().message);
    const ErrorCode code = served.error().code;
    exit_code =
        code == ErrorCode::argument || code == ErrorCode::not_found ? kExitUsage : kExitFailed;
  });
}

}  // namespace pointreel
