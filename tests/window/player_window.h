#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/e2e/picture.h"
#include "tests/e2e/process.h"
#include "tests/wait.h"
#include "tests/window/virtual_display.h"

namespace pointreel::window {

/// `pointreel play` in a real window, with a simulated user at its keys and mouse.
class PlayerWindow {
 public:
  struct Options {
    std::vector<std::string> arguments;  ///< for `pointreel play`
    /// The working folder, also for output: figures, standard error, settings.
    std::filesystem::path folder;
    std::vector<std::string> environment;  ///< "NAME=VALUE"
  };

  /// Starts the player and waits for its window. Fails if there is none within a minute.
  static Result<std::unique_ptr<PlayerWindow>> open(VirtualDisplay& display,
                                                    const Options& options);

  /// Takes names of keys as in xdotool: "space", "Right", "question", "shift+Left".
  void key(const std::string& name);
  void move_to(glm::ivec2 pixel);
  void click(glm::ivec2 pixel, int button = 1);
  void double_click(glm::ivec2 pixel);
  void press(glm::ivec2 pixel, int button = 1);
  void release(int button = 1);
  /// Presses the button, moves there in some steps, and releases it.
  void drag(glm::ivec2 from, glm::ivec2 to, int button = 1);
  void scroll(int notches);  ///< positive: away from the user
  void key_down(const std::string& name);
  void key_up(const std::string& name);
  void resize(glm::ivec2 size);
  bool drop(const std::vector<std::filesystem::path>& files);

  e2e::Picture picture() const { return display_.picture(window_); }
  glm::ivec2 size() const { return display_.size(window_); }
  std::string title() const { return display_.title(window_); }
  /// Returns what it has written to standard error so far.
  std::string err() const;
  bool running() const { return process_.running(); }
  pid_t pid() const { return process_.pid(); }

  /// Presses "q" and waits for at most a minute until the player ends. Returns what it reports in
  /// --json, or a discarded value if it ended with an error.
  nlohmann::json quit();
  /// The same, but closes the window as a window manager does.
  nlohmann::json close();
  int exit_code() const { return exit_code_; }  ///< after quit or close

 private:
  PlayerWindow(VirtualDisplay& display, const Options& options);
  nlohmann::json wait_for_end();

  VirtualDisplay& display_;
  std::filesystem::path folder_;
  e2e::Background process_;
  WindowId window_ = 0;
  int exit_code_ = -1;
};

/// As pointreel::wait_until, but with longer pauses, since looking at the display takes processor
/// time that the player needs to draw.
template <class Condition>
bool wait_until(Condition&& condition,
                std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
  return pointreel::wait_until(condition, timeout, std::chrono::milliseconds(5));
}

/// Returns the value of `look` once it has not changed for `time` and is `good`, or nothing if that
/// does not happen within a minute.
template <class Look, class Good>
auto wait_until_still(const Look& look, std::chrono::milliseconds time, const Good& good)
    -> std::optional<decltype(look())> {
  auto seen = look();
  auto since = std::chrono::steady_clock::now();
  const bool still = wait_until([&] {
    if (auto now = look(); now != seen) {
      seen = std::move(now);
      since = std::chrono::steady_clock::now();
    }
    return good(seen) && std::chrono::steady_clock::now() - since > time;
  });
  if (!still) return std::nullopt;
  return seen;
}
template <class Look>
auto wait_until_still(const Look& look, std::chrono::milliseconds time) {
  return wait_until_still(look, time, [](const auto&) { return true; });
}

}  // namespace pointreel::window
