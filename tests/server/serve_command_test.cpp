// Runs `pointreel-server serve` as a process: its output, its failures and its end.

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/paths.h"
#include "tests/raw_http_client.h"
#include "tests/served_package.h"
#include "tests/wait.h"

namespace pointreel::serve_command_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// A run of the server's executable, which is ended with the test at the latest.
class ServerProcess {
 public:
  /// `descriptors` > 0 limits how many file descriptors it may have open.
  explicit ServerProcess(const std::vector<std::string>& arguments, rlim_t descriptors = 0) {
    std::array<int, 2> out{}, err{};
    if (::pipe2(out.data(), O_CLOEXEC) != 0 || ::pipe2(err.data(), O_CLOEXEC) != 0) {
      ADD_FAILURE() << "the pipe cannot be made";
      return;
    }
    std::vector<std::string> words{program_folder() / "pointreel-server", "serve"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    child_ = ::fork();
    if (child_ == 0) {
      ::dup2(out[1], STDOUT_FILENO);
      ::dup2(err[1], STDERR_FILENO);
      const rlimit limit{descriptors, descriptors};
      if (descriptors > 0) ::setrlimit(RLIMIT_NOFILE, &limit);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(out[1]);
    ::close(err[1]);
    out_ = out[0];
    err_ = err[0];
  }
  ~ServerProcess() {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(child_, nullptr, 0);
    }
    ::close(out_);
    ::close(err_);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  /// Returns the port from the line that announces the address, or 0 if there is no such line.
  std::uint16_t port() {
    const std::string start = "listening on http://127.0.0.1:";
    const std::string line = read(out_, true);
    if (!line.starts_with(start)) {
      ADD_FAILURE() << "printed '" << line << "' and '" << errors() << "'";
      return 0;
    }
    return static_cast<std::uint16_t>(std::atoi(line.c_str() + start.size()));
  }
  /// Returns all of standard error once the process has ended.
  std::string errors() { return read(err_, false); }
  /// Returns the processor time of all its threads since its start.
  std::chrono::milliseconds processor_time() const {
    std::ifstream file("/proc/" + std::to_string(child_) + "/stat");
    std::string word;
    long ticks = 0, value = 0;
    for (int i = 1; i <= 13; ++i) file >> word;  // its name, the second field, has no space
    for (int i = 0; i < 2 && file >> value; ++i) ticks += value;
    return std::chrono::milliseconds(ticks * 1000 / ::sysconf(_SC_CLK_TCK));
  }
  void signal(int number) { ::kill(child_, number); }
  /// Returns the exit code, 128 plus the signal number if a signal ended it, or -1 if it still
  /// runs.
  int exit_code() {
    int status = 0;
    if (!wait_until([&] { return ::waitpid(child_, &status, WNOHANG) == child_; })) return -1;
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  static std::string read(int pipe, bool line) {
    std::string text;
    for (pollfd waiting{pipe, POLLIN, 0}; ::poll(&waiting, 1, 60'000) == 1;) {
      char c = 0;
      if (::read(pipe, &c, 1) != 1 || (line && c == '\n')) break;
      text += c;
    }
    return text;
  }

  pid_t child_ = -1;
  int out_ = -1, err_ = -1;
};

class ServeCommandTest : public testing::Test {
 protected:
  ServeCommandTest() { write_package(reel_, "base", patterned(16 << 20)); }

  /// Returns the single line on standard error of a run that must fail: with exit code 2 if its
  /// command line is wrong, or a folder is not a package, and with 1 otherwise.
  std::string failure_of(const std::vector<std::string>& arguments, int exit_code = 2) {
    ServerProcess server(arguments);
    EXPECT_EQ(server.exit_code(), exit_code);
    std::string text = server.errors();
    EXPECT_EQ(text.find('\n'), text.size() - 1) << text;
    return text;
  }

  TemporaryFolder temporary_;
  fs::path reel_ = temporary_.path() / "walk";
};

TEST_F(ServeCommandTest, serves_until_a_signal_and_then_exits_at_once) {
  for (const int number : {SIGINT, SIGTERM}) {
    ServerProcess server({reel_.string(), "--listen", "127.0.0.1:0"});
    const std::uint16_t port = server.port();
    ASSERT_NE(port, 0);
    RawHttpClient idle(port), stalled(port, 4096), silent(port);
    EXPECT_EQ(idle.get("/walk/0.base.prs").body, "base");
    stalled.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_TRUE(stalled.has_something());
    server.signal(number);
    EXPECT_EQ(server.exit_code(), 0) << number;
    EXPECT_TRUE(idle.ends());
    EXPECT_EQ(server.errors(), "");
  }
}

TEST_F(ServeCommandTest, survives_readers_that_disconnect_in_the_middle) {
  ServerProcess server({reel_.string(), "--listen", "127.0.0.1:0"});
  const std::uint16_t port = server.port();
  ASSERT_NE(port, 0);
  for (int i = 0; i < 50; ++i) {
    RawHttpClient leaving(port);
    leaving.send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n");
    if (i % 2 == 1) continue;
    EXPECT_TRUE(leaving.has_something()) << "no response has begun before the client leaves";
  }
  EXPECT_EQ(RawHttpClient(port).get("/walk/0.base.prs").body, "base");
}

TEST_F(ServeCommandTest, recovers_from_running_out_of_file_descriptors) {
  ServerProcess server({reel_.string(), "--listen", "127.0.0.1:0"}, 24);
  const std::uint16_t port = server.port();
  ASSERT_NE(port, 0);
  {
    std::vector<std::unique_ptr<RawHttpClient>> many;
    for (int i = 0; i < 60; ++i) many.push_back(std::make_unique<RawHttpClient>(port));
    // The first connection was accepted while descriptors were left. Soon there is none for another
    // file than the one that it has open.
    int status = 200;
    const auto get = [&](const char* file) {
      status = many.front()->get(file, "Range: bytes=0-0\r\n").status;
      return status != 206;
    };
    wait_until([&] { return get("/walk/0.base.prs") || get("/walk/0.full.prs"); });
    EXPECT_EQ(status, 503);
    EXPECT_EQ(many.front()->get("/walk/reel.json").status, 200);
    const auto is_quiet = [&] {
      const auto before = server.processor_time();
      std::this_thread::sleep_for(200ms);  // the period over which processor time is measured
      return server.processor_time() - before < 100ms;
    };
    bool quiet = false;
    for (int i = 0; i < 20 && !quiet; ++i) quiet = is_quiet();
    EXPECT_TRUE(quiet) << "the server spins instead of waiting";
  }
  EXPECT_EQ(RawHttpClient(port).get("/walk/0.base.prs").body, "base");
}

TEST_F(ServeCommandTest, takes_an_empty_token_for_a_mistake_wherever_it_is_set) {
  for (const std::string option : {"--view-token", "--publish-token"}) {
    EXPECT_THAT(failure_of({reel_.string(), option, ""}), HasSubstr(option + ": is empty"));
    EXPECT_THAT(failure_of({reel_.string(), option, "two words"}), HasSubstr(option));
  }
  for (const char* variable : {"POINTREEL_VIEW_TOKEN", "POINTREEL_PUBLISH_TOKEN"}) {
    ::setenv(variable, "", 1);
    EXPECT_THAT(failure_of({reel_.string()}), HasSubstr(std::string(variable) + ": is empty"));
    ::unsetenv(variable);
  }
}

TEST_F(ServeCommandTest, refuses_numbers_that_are_none) {
  for (const char* option :
       {"--idle-timeout", "--header-timeout", "--stall-timeout", "--max-requests", "--publish-rate",
        "--least-rate", "--publisher-grace"}) {
    for (const std::string number : {"nan", "-nan", "inf", "-1", "1e300"}) {
      ServerProcess server({reel_.string(), "--listen", "127.0.0.1:0", option + ("=" + number)});
      EXPECT_EQ(server.exit_code(), 2) << option << ' ' << number;
    }
  }
}

TEST_F(ServeCommandTest, ends_although_nobody_reads_what_it_prints) {
  ServerProcess server({reel_.string(), "--listen", "127.0.0.1:0", "--log", "info"});
  const std::uint16_t port = server.port();
  ASSERT_NE(port, 0);
  // Far more than a pipe holds.
  RawHttpClient client(port);
  const std::string target = "/" + std::string(2000, 'x');
  for (int i = 0; i < 200; ++i) ASSERT_EQ(client.get(target).status, 404);
  server.signal(SIGTERM);
  EXPECT_EQ(server.exit_code(), 0);
}

TEST_F(ServeCommandTest, packages_tokens_and_the_certificate_change_while_it_serves) {
  const fs::path all = temporary_.path() / "all", config = temporary_.path() / "server.toml";
  fs::create_directory(all);
  write_file(config, "[serve]\nreels = [\"" + all.string() + "\"]\n");
  ServerProcess server({"--config", config.string(), "--listen", "127.0.0.1:0"});
  const std::uint16_t port = server.port();
  ASSERT_NE(port, 0);
  const auto status = [&](const std::string& target, const std::string& fields = "") {
    return RawHttpClient(port).get(target, fields).status;
  };
  EXPECT_EQ(status("/sub/new/reel.json"), 404);
  write_package(all / "sub" / "new", "1", "2");
  EXPECT_TRUE(wait_until([&] { return status("/sub/new/reel.json") == 200; }));
  fs::remove_all(all / "sub");
  EXPECT_TRUE(wait_until([&] { return status("/sub/new/reel.json") == 404; }));

  const std::string folders = "[serve]\nreels = [  # all\n  \"" + reel_.string() + "\"\n]\n";
  write_file(config, folders + "view-token = \"#one\"  # for a start\n");
  server.signal(SIGHUP);
  EXPECT_TRUE(wait_until([&] { return status("/") == 401; }));
  const std::string manifest = "/" + reel_.filename().string() + "/reel.json";
  EXPECT_TRUE(
      wait_until([&] { return status(manifest, "Authorization: Bearer #one\r\n") == 200; }));
  // A file with a mistake, or a pipe in its place, changes nothing.
  write_file(config, folders + "view-tokn = \"two\"\n");
  server.signal(SIGHUP);
  write_file(config, folders + "view-token = \"\"\n");
  server.signal(SIGHUP);
  write_file(config, folders);  // as while it is being written
  server.signal(SIGHUP);
  fs::remove(config);
  ASSERT_EQ(::mkfifo(config.c_str(), 0600), 0);
  server.signal(SIGHUP);
  EXPECT_FALSE(wait_until([&] { return status("/") != 401; }, kMoment));
  fs::remove(config);
  write_file(config, folders + "view-token = \"two\"\n");
  server.signal(SIGHUP);
  EXPECT_TRUE(wait_until([&] { return status(manifest, "Authorization: Bearer two\r\n") == 200; }));
  server.signal(SIGTERM);
  EXPECT_EQ(server.exit_code(), 0);
}

TEST_F(ServeCommandTest, reports_every_failure_in_one_line) {
  fs::create_directory(temporary_.path() / "frames");
  write_file(temporary_.path() / "frames" / "1.ply", "ply");
  EXPECT_THAT(failure_of({(temporary_.path() / "frames").string()}),
              HasSubstr("frames: holds no reel.json, and no packages"));
  EXPECT_THAT(failure_of({"--relay-from", "ws://localhost/live"}), HasSubstr("--live"));
  for (const char* bad : {"http://localhost/live", "ws://localhost/", "ws://localhost/live/a/b",
                          "name=ws://localhost/live", "a/b=ws://localhost/live/c"}) {
    EXPECT_THAT(failure_of({"--live", "--listen", "127.0.0.1:0", "--relay-from", bad}),
                HasSubstr("--relay-from"))
        << bad;
  }
  EXPECT_THAT(failure_of({reel_.string(), reel_.string()}), HasSubstr("another package is named"));
  EXPECT_THAT(failure_of({reel_.string(), "--listen", "nowhere"}), HasSubstr("--listen nowhere"));
  EXPECT_THAT(failure_of({reel_.string(), "--embed-in", "example.org"}),
              HasSubstr("--embed-in example.org"));
  EXPECT_THAT(failure_of({reel_.string(), "--allow-origin", "example.org"}),
              HasSubstr("--allow-origin example.org"));
  EXPECT_THAT(failure_of({"--live", "--listen", "0.0.0.0:0"}), HasSubstr("needs --publish-token"));
  EXPECT_THAT(failure_of({"--live", "--max-unfinished", "1M"}), HasSubstr("--max-unfinished"));
  ServerProcess first({reel_.string(), "--listen", "127.0.0.1:0"});
  const std::string taken = "127.0.0.1:" + std::to_string(first.port());
  EXPECT_THAT(failure_of({reel_.string(), "--listen", taken}, 1),
              HasSubstr("cannot listen on " + taken + ": Address already in use"));
  EXPECT_THAT(failure_of({(reel_ / "nowhere").string()}), HasSubstr("No such file or directory"));
  fs::remove(reel_ / "0.base.prs");
  EXPECT_THAT(failure_of({reel_.string()}, 1), HasSubstr("0.base.prs"));
}

TEST_F(ServeCommandTest, names_an_unknown_option_of_a_configuration_file) {
  const fs::path config = temporary_.path() / "server.toml";
  std::ofstream(config) << "[serve]\nlistem = \"127.0.0.1:0\"\n";
  EXPECT_THAT(failure_of({reel_.string(), "--config", config.string()}),
              HasSubstr("--config: line 2: serve has no option listem"));
}

TEST_F(ServeCommandTest, says_nothing_of_tokens_in_a_configuration_file_that_it_cannot_read) {
  const fs::path config = temporary_.path() / "server.toml";
  for (const auto& [text, said] :
       {std::pair{"[serve]\nview-token \"SECRET\"\n", "line 2: this is not TOML"},
        {"# tokens\n[serve]\npublish-token: SECRET\n", "line 3: this is not TOML"},
        {"[serve]\nview-token =\n\"SECRET\"\n", "line 2: this is not TOML"},
        {"[serve]\nview-token = SECRET#x\n", "line 2: this is not TOML"},
        {"{\"serve\": {\"view-token\": \"SECRET\"}}", "line 1: this is not TOML"},
        {"[serve]\n= SECRET\n", "line 2: this is not TOML"},
        {"[serve]\nreels = [\"a\"\nview-token = SECRET\n", "line 3: this is not TOML"},
        {"[serve]\nview-token = \"SECRET\n", "line 2: this is not TOML"},
        {"[serve]\nview-token = \"SECRET\"\nview-token = \"SECRET\"\n",
         "line 3: this table or name"},
        {"[serve]\nview-token = \"SECRET\"\n# don't\n [serve] # again\nview-token = \"SECRET\"\n",
         "line 4: this table or name is set a second time"},
        {"[serve]\nview-token = 2000-01-01\n", "line 2: a value is text in quotes"},
        {"view-token = \"SECRET\"\n", "line 1: this stands below no line [serve]"},
        {"[Serve]\nview-token = \"SECRET\"\n", "line 2: this stands below no line [serve]"},
        {"[serve]\nlive = 5\n", "line 2: live is true or false"},
        {"[serve]\nview-token = true\n", "line 2: view-token takes a value, not true or false"},
        {"[serve]\nview-token = [\"a\", \"SECRET\"]\n", "line 2: view-token takes one value"},
        {"[serve]\nview-tokn = \"SECRET\"\n", "line 2: serve has no option view-tokn"}}) {
    std::ofstream(config) << text;
    const std::string failure = failure_of({reel_.string(), "--config", config.string()});
    EXPECT_THAT(failure, HasSubstr(said)) << text;
    EXPECT_THAT(failure, testing::Not(HasSubstr("SECRET")));
  }
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "a.";
  for (const std::string& line : {deep + "a = 1", "[" + deep + "a]"}) {
    std::ofstream(config) << "[serve]\n" << line << "\n";
    EXPECT_THAT(failure_of({reel_.string(), "--config", config.string()}),
                HasSubstr("--config: line 2: this has too many dots"));
  }
  EXPECT_THAT(failure_of({reel_.string(), "--config", "/dev/zero"}),
              HasSubstr("--config: the file is larger than 1 MiB"));
}

}  // namespace
}  // namespace pointreel::serve_command_test
