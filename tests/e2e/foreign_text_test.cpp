// Whatever files, reels and servers are called, and whatever servers say, no program passes on to
// the terminal what would control it.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/e2e/process.h"
#include "tests/scripted_http_server.h"
#include "tests/temporary_folder.h"
#include "tests/terminal_text.h"

namespace pointreel::e2e::foreign_text_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n0 0 0\n1 1 1\n";

class ForeignText : public testing::Test {
 protected:
  /// Runs the program and looks at what it prints.
  void expect_harmless(const std::string& program, const std::vector<std::string>& arguments) {
    const Outcome outcome = run(program, arguments);
    EXPECT_LT(outcome.exit_code, 3) << program;  // no crash
    EXPECT_EQ(harm_to_terminal(outcome.err), "")
        << program << " " << arguments[0] << ": " << outcome.err;
    EXPECT_EQ(harm_to_terminal(outcome.out), "")
        << program << " " << arguments[0] << ": " << outcome.out;
    printed_ += outcome.out + outcome.err;
  }

  const TemporaryFolder folder_;
  std::mt19937 random_{7};
  std::string printed_;
};

TEST_F(ForeignText, on_the_command_line_is_printed_harmlessly) {
  for (int trial = 0; trial < 4; ++trial) {
    const std::string name = "\x1b]0;x\x07\n" + foreign_text(random_);
    const std::string path = (folder_ / name).string();
    expect_harmless("pointreel", {"play", path, "--offscreen", "64x64"});
    expect_harmless("pointreel", {"play", "x", "--camera", name});
    expect_harmless("pointreel", {"play", "x", "--" + name});
    expect_harmless("pointreel", {"play", "ws://" + name, "--offscreen", "64x64"});
    for (const char* command : {"info", "verify"})
      expect_harmless("pointreel-server", {command, path});
    expect_harmless("pointreel-server", {"pack", "-i", path, "-o", path + "x"});
    expect_harmless("pointreel-server", {"unpack", "-i", path, "-o", path + "x"});
    expect_harmless("pointreel-server", {"serve", path});
    expect_harmless("pointreel-server", {"serve", "--" + name});
    expect_harmless("pointreel-server", {"publish", "-i", path, "--to", "ws://" + name});
    expect_harmless("pointreel-synth", {name});
    expect_harmless("pointreel-link", {"--to", name});
  }
  EXPECT_NE(printed_.find("\\x1b]0;x\\x07\\n"), std::string::npos);
}

TEST_F(ForeignText, in_the_names_of_files_and_reels_is_printed_harmlessly) {
  for (int trial = 0; trial < 4; ++trial) {
    const std::string title = "\xc3\xa9t\xc3\xa9";
    const std::string foreign_title =
        "x\xc2\x9b"
        "2J\xe2\x80\xae";
    const std::string name =
        "\x1b]0;x\x07\xc2\x9b"
        "2J\xe2\x80\xae" +
        foreign_text(random_);
    const std::string frames = (folder_ / name).string(), reel = frames + "-reel";
    fs::create_directories(frames);
    std::ofstream(fs::path(frames) / (name + ".ply")) << kPly;
    std::ofstream(fs::path(frames) / (name + "2.ply")) << "ply\nbroken";
    expect_harmless("pointreel-server", {"pack", "-i", frames, "-o", reel, "--name", title});
    expect_harmless("pointreel-server",
                    {"pack", "-i", frames, "-o", reel, "--name", foreign_title});
    fs::remove(fs::path(frames) / (name + "2.ply"));
    expect_harmless("pointreel-server", {"pack", "-i", frames, "-o", reel, "--name", title});
    expect_harmless("pointreel-server",
                    {"pack", "-i", frames, "-o", reel, "--name", title, "--force", "--json"});
    ASSERT_TRUE(fs::exists(fs::path(reel) / "reel.json"));
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--json"}}) {
      for (const char* command : {"info", "verify"}) {
        std::vector<std::string> all = {command, reel};
        all.insert(all.end(), more.begin(), more.end());
        expect_harmless("pointreel-server", all);
      }
    }
    expect_harmless("pointreel", {"play", reel, "--offscreen", "64x64", "--json", "-"});
    expect_harmless("pointreel", {"play", frames, "--offscreen", "64x64", "--at", "9"});
    for (const auto& file : fs::directory_iterator(reel))
      if (file.path().extension() == ".prs") fs::resize_file(file.path(), 1);
    expect_harmless("pointreel-server", {"verify", reel});
    expect_harmless("pointreel", {"play", reel, "--offscreen", "64x64"});
  }
}

TEST_F(ForeignText, in_the_answers_of_servers_is_printed_harmlessly) {
  for (int trial = 0; trial < 8; ++trial) {
    std::string text =
        "\x1b]0;x\x07\xc2\x9b"
        "2J" +
        foreign_text(random_);
    std::string header = text;
    for (char& c : header)
      if (c == '\r' || c == '\n') c = '\x1b';
    const ScriptedHttpServer server([&](int socket, const std::string& head) {
      const bool redirect = head.find("/redirect/") != std::string::npos;
      if (redirect)
        answer(socket, "302 " + header, "Location: http://" + header + "/\r\n", text);
      else if (head.find("Upgrade") != std::string::npos)
        answer(socket, "403 " + header, "", text);
      else
        answer(socket, "200 OK", "Content-Range: " + header + "\r\n",
               "{\"format\": \"" + text + "\"");
      return true;
    });
    const std::string place = server.url().substr(4);
    for (const std::string& url : {"http" + place + "/walk", "http" + place + "/redirect/walk",
                                   "http" + place + "/live/walk", "ws" + place + "/live/walk"})
      expect_harmless("pointreel", {"play", url, "--offscreen", "64x64", "--duration", "0.5"});
  }
}

}  // namespace
}  // namespace pointreel::e2e::foreign_text_test
