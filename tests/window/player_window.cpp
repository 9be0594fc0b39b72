#include "tests/window/player_window.h"

#include <fstream>
#include <iterator>
#include <thread>

#include <fmt/format.h>

namespace pointreel::window {
namespace {

std::vector<std::string> arguments(const PlayerWindow::Options& options) {
  std::vector<std::string> all = {"play"};
  all.insert(all.end(), options.arguments.begin(), options.arguments.end());
  // The limit ends the player even if the test that started it is killed.
  all.insert(all.end(), {"--json", (options.folder / "play.json").string(), "--duration", "300"});
  return all;
}

e2e::Surroundings surroundings(const VirtualDisplay& display,
                               const PlayerWindow::Options& options) {
  std::vector<std::string> environment = {
      "DISPLAY=" + display.name(),
      "WAYLAND_DISPLAY=", "XDG_CONFIG_HOME=" + (options.folder / "config").string()};
  environment.insert(environment.end(), options.environment.begin(), options.environment.end());
  return {environment, (options.folder / "err.txt").string(), options.folder.string()};
}

std::string content(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

PlayerWindow::PlayerWindow(VirtualDisplay& display, const Options& options)
    : display_(display),
      folder_(options.folder),
      process_("pointreel", arguments(options), surroundings(display, options)) {}

Result<std::unique_ptr<PlayerWindow>> PlayerWindow::open(VirtualDisplay& display,
                                                         const Options& options) {
  std::error_code ignored;
  std::filesystem::create_directories(options.folder / "config", ignored);
  std::filesystem::remove(options.folder / "play.json", ignored);
  std::unique_ptr<PlayerWindow> player(new PlayerWindow(display, options));
  const bool there =
      wait_until([&] { return (player->window_ = display.window()) != 0 || !player->running(); });
  if (!there || player->window_ == 0) return fail("no window: " + player->err());
  const std::string window = std::to_string(player->window_);
  // What a window manager would do for a new window.
  display.xdotool({"windowfocus", "--sync", window});
  return player;
}

void PlayerWindow::key(const std::string& name) { display_.xdotool({"key", name}); }
void PlayerWindow::key_down(const std::string& name) { display_.xdotool({"keydown", name}); }
void PlayerWindow::key_up(const std::string& name) { display_.xdotool({"keyup", name}); }

namespace {

std::vector<std::string> to(WindowId window, glm::ivec2 pixel) {
  return {"mousemove", "--window", std::to_string(window), std::to_string(pixel.x),
          std::to_string(pixel.y)};
}

std::vector<std::string> operator+(std::vector<std::string> one,
                                   const std::vector<std::string>& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

}  // namespace

void PlayerWindow::move_to(glm::ivec2 pixel) { display_.xdotool(to(window_, pixel)); }

void PlayerWindow::press(glm::ivec2 pixel, int button) {
  display_.xdotool(to(window_, pixel) +
                   std::vector<std::string>{"mousedown", std::to_string(button)});
}

void PlayerWindow::release(int button) { display_.xdotool({"mouseup", std::to_string(button)}); }

void PlayerWindow::click(glm::ivec2 pixel, int button) {
  // A button counts as pressed only if the mouse is over it in one picture and pressed in another,
  // and nothing outside the player shows when it has drawn those. So this is as slow as a hand.
  constexpr std::chrono::milliseconds kHand{80};
  move_to(pixel);
  std::this_thread::sleep_for(kHand);
  press(pixel, button);
  std::this_thread::sleep_for(kHand);
  release(button);
  std::this_thread::sleep_for(kHand);
}

void PlayerWindow::double_click(glm::ivec2 pixel) {
  display_.xdotool(to(window_, pixel) +
                   std::vector<std::string>{"click", "--repeat", "2", "--delay", "60", "1"});
}

void PlayerWindow::drag(glm::ivec2 from, glm::ivec2 to_pixel, int button) {
  press(from, button);
  constexpr int kSteps = 4;
  for (int i = 1; i <= kSteps; ++i) move_to(from + (to_pixel - from) * i / kSteps);
  release(button);
}

void PlayerWindow::scroll(int notches) {
  const char* button = notches > 0 ? "4" : "5";
  for (int i = 0; i < std::abs(notches); ++i) display_.xdotool({"click", button});
}

void PlayerWindow::resize(glm::ivec2 size) {
  display_.xdotool({"windowsize", "--sync", std::to_string(window_), std::to_string(size.x),
                    std::to_string(size.y)});
}

bool PlayerWindow::drop(const std::vector<std::filesystem::path>& files) {
  return display_.drop(window_, files);
}

std::string PlayerWindow::err() const { return content(folder_ / "err.txt"); }

nlohmann::json PlayerWindow::quit() {
  key("q");
  return wait_for_end();
}

nlohmann::json PlayerWindow::close() {
  display_.close(window_);
  return wait_for_end();
}

nlohmann::json PlayerWindow::wait_for_end() {
  exit_code_ = process_.end(0);
  return nlohmann::json::parse(content(folder_ / "play.json"), nullptr, false);
}

}  // namespace pointreel::window
