// The programs end when they are told to, whatever they wait for, and where they cannot start.

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stop_token>
#include <string>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/e2e/process.h"
#include "tests/paths.h"
#include "tests/scripted_http_server.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::e2e::interrupt_test {
namespace {

using testing::HasSubstr;

/// A server that brings its clients nothing they can use, until it ends.
class UselessServer {
 public:
  enum class Way {
    silent,     ///< it accepts connections and answers nothing
    dripping,   ///< the head of its answer comes one byte at a time and never ends
    no_frames,  ///< it sends the manifest, but no frame
  };
  UselessServer(Way way, std::string manifest = {})
      : server_([this, way, manifest = std::move(manifest)](int socket, const std::string& head) {
          if (way == Way::no_frames && head.find("/reel.json ") != std::string::npos) {
            answer(socket, "200 OK", "", manifest);
            return true;
          }
          ++stuck_;
          if (way == Way::dripping) send_text(socket, "HTTP/1.1 200 OK\r\n");
          while (!ended_.stop_requested()) {
            if (way == Way::dripping) send_text(socket, "X-Filler: 1\r\n");
            wait_until([this] { return ended_.stop_requested(); }, std::chrono::milliseconds(100));
          }
          return false;
        }) {}
  ~UselessServer() { ended_.request_stop(); }

  std::string url(const std::string& scheme, const std::string& path) const {
    return scheme + server_.url().substr(server_.url().find(':')) + path;
  }
  /// Whether a client waits for what will never come.
  bool stuck() const { return stuck_ > 0; }

 private:
  std::stop_source ended_;
  std::atomic<int> stuck_ = 0;
  ScriptedHttpServer server_;
};

std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

/// Whether the first thread of a process blocks a signal, so that another one waits for it.
bool catches(pid_t pid, int signal) {
  std::istringstream lines(read_text(fmt::format("/proc/{}/status", pid)));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("SigBlk:"))
      return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
  }
  return false;
}

class Interrupt : public testing::Test {
 protected:
  /// Interrupts the player once `stuck`. Returns what it printed.
  template <class Condition>
  std::string interrupted(const std::string& source, int signal, const Condition& stuck,
                          const std::vector<std::string>& environment = {},
                          const std::vector<std::string>& options = {}) {
    const std::string err = (folder_ / "err").string();
    std::vector<std::string> arguments{"play", source, "--offscreen", "64x64"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    Background player("pointreel", arguments, {environment, err, {}});
    EXPECT_TRUE(wait_until(stuck)) << source;
    EXPECT_TRUE(player.running());
    // A player that went on would fail in the end, or be killed after a minute.
    EXPECT_EQ(player.end(signal), options.empty() ? 0 : 1) << source;
    return read_text(err);
  }

  /// A file of two points.
  std::filesystem::path cloud() const {
    return folder_.write(
        "in/a.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 1 1\n");
  }

  const TemporaryFolder folder_;
};

TEST_F(Interrupt, ends_the_player_while_a_server_answers_nothing_or_drips) {
  using Way = UselessServer::Way;
  for (const Way way : {Way::silent, Way::dripping}) {
    for (const auto& [scheme, path] : {std::pair("http", "/walk"), std::pair("http", "/live/walk"),
                                       std::pair("ws", "/live/walk")}) {
      const UselessServer server(way);
      interrupted(server.url(scheme, path), way == Way::silent ? SIGINT : SIGTERM,
                  [&] { return server.stuck(); });
    }
  }
}

TEST_F(Interrupt, a_screenshot_that_was_not_written_is_an_error) {
  const UselessServer server(UselessServer::Way::silent);
  EXPECT_THAT(interrupted(server.url("http", "/walk"), SIGTERM, [&] { return server.stuck(); }, {},
                          {"--screenshot", (folder_ / "a.png").string()}),
              HasSubstr("interrupted, nothing was written"));
}

TEST_F(Interrupt, ends_the_player_while_no_frame_ever_comes) {
  const std::string reel = (folder_ / "reel").string();
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", cloud().string(), "-o", reel}).exit_code, 0);
  const UselessServer server(UselessServer::Way::no_frames, read_text(reel + "/reel.json"));
  interrupted(server.url("http", "/reel"), SIGINT, [&] { return server.stuck(); });

  const Outcome played = run("pointreel", {"play", server.url("http", "/reel"), "--offscreen",
                                           "64x64", "--duration", "1"});
  EXPECT_EQ(played.exit_code, 1);
  EXPECT_THAT(played.err, HasSubstr("no frame came within the 1 s of --duration"));
}

TEST_F(Interrupt, a_duration_ends_the_player_even_if_nothing_ever_comes) {
  const UselessServer server(UselessServer::Way::silent);
  for (const auto& [scheme, path] : {std::pair("http", "/walk"), std::pair("http", "/live/walk"),
                                     std::pair("ws", "/live/walk")}) {
    const Outcome played = run("pointreel", {"play", server.url(scheme, path), "--offscreen",
                                             "64x64", "--duration", "0.5"});
    EXPECT_EQ(played.exit_code, 1) << path;
    EXPECT_THAT(played.err, HasSubstr("no frame came within the 0.5 s of --duration")) << path;
  }
}

TEST_F(Interrupt, ends_the_player_while_the_lookup_of_a_name_hangs) {
#ifdef POINTREEL_SANITIZED
  GTEST_SKIP() << "a sanitizer must be the first library of a program";
#endif
  const auto no_lookup = program_folder() / "libpointreel_no_lookup.so";
  for (const char* source : {"http://somewhere.example/walk", "ws://somewhere.example/live/walk"}) {
    const auto begun = folder_ / (std::string("begun-") + source[0]);
    interrupted(source, SIGINT, [&] { return std::filesystem::exists(begun); },
                {"LD_PRELOAD=" + no_lookup.string(), "POINTREEL_LOOKUP_BEGUN=" + begun.string()});
  }
}

TEST_F(Interrupt, too_few_threads_are_an_error_that_ends_the_programs) {
#ifdef POINTREEL_SANITIZED
  GTEST_SKIP() << "a sanitizer must be the first library of a program";
#endif
  const std::string reel = (folder_ / "reel").string(), err = (folder_ / "err").string();
  ASSERT_EQ(run("pointreel-server", {"pack", "-i", cloud().string(), "-o", reel}).exit_code, 0);
  const std::string preloaded = (program_folder() / "libpointreel_few_threads.so").string();
  const std::vector<std::string> play{
      "play",       reel,       "--offscreen",  "64x64",
      "--renderer", "software", "--screenshot", (folder_ / "a.png").string()};
  const std::vector<std::string> serve{"serve", reel, "--listen", "127.0.0.1:0"};
  int refused = 0;
  for (int threads = 0; threads < 8; ++threads) {
    for (const auto& [program, arguments] :
         {std::pair("pointreel", play), std::pair("pointreel-server", serve)}) {
      Background started(
          program, arguments,
          {{"LD_PRELOAD=" + preloaded, fmt::format("POINTREEL_THREADS={}", threads)}, err, {}});
      const bool serves = !started.first_line().empty() && arguments == serve;
      const int code = started.end(serves ? SIGTERM : 0);
      EXPECT_LE(code, 1) << program << " with " << threads << " threads: " << read_text(err);
      if (code == 0) continue;
      ++refused;
      EXPECT_THAT(read_text(err), HasSubstr("Resource temporarily unavailable"));
    }
  }
  EXPECT_GE(refused, 2);
}

TEST_F(Interrupt, ends_packing_while_nothing_comes_through_a_pipe) {
  const auto pipe = folder_ / "a.ply";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const bool written : {false, true}) {
    Background packing("pointreel-server",
                       {"pack", "-i", pipe.string(), "-o", (folder_ / "reel").string()},
                       {{}, (folder_ / "err").string(), {}});
    int writer = -1;
    if (written) {
      // Opens once somebody reads.
      ASSERT_TRUE(wait_until(
          [&] { return (writer = ::open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC)) >= 0; }));
      ASSERT_EQ(::write(writer, "ply\n", 4), 4);
    } else {
      ASSERT_TRUE(wait_until([&] { return catches(packing.pid(), SIGTERM); }));
    }
    EXPECT_EQ(packing.end(SIGTERM), 1);
    if (writer >= 0) ::close(writer);
    EXPECT_THAT(read_text(folder_ / "err"), HasSubstr("interrupted"));
  }
}

}  // namespace
}  // namespace pointreel::e2e::interrupt_test
