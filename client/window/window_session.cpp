#include "client/window/window_session.h"

#include <algorithm>
#include <utility>

#include "client/session/stage_setup.h"
#include "common/net/url.h"
#include "common/process/print.h"

namespace pointreel {
namespace {

std::string short_name(std::string where) {
  while (where.size() > 1 && where.back() == '/') where.pop_back();
  const std::size_t slash = where.rfind('/');
  return slash == std::string::npos || slash + 1 == where.size() ? where : where.substr(slash + 1);
}

}  // namespace

std::string short_names(const std::vector<Stage::Placed>& sources) {
  std::string names;
  for (const Stage::Placed& source : sources)
    names += (names.empty() ? "" : ", ") + short_name(without_secrets(source.where));
  return visible(names);
}

WindowSession::WindowSession(const PlayOptions& options, WindowErrors& errors,
                             Playback::OnReady on_ready)
    : options_(options),
      errors_(errors),
      on_ready_(std::move(on_ready)),
      audio_(options.audio ? std::optional(options.audio_device) : std::nullopt,
             [this](std::size_t source, const Error& error) {
               errors_.broken(source, playing_[source], std::nullopt, error);
             }) {}

WindowSession::~WindowSession() { play(nullptr); }

void WindowSession::open(std::vector<Stage::Placed> sources, const Settings& settings,
                         glm::ivec2 size) {
  opened_ = std::move(sources);
  opening_since_ = std::chrono::steady_clock::now();
  PlayOptions options = options_;
  options.settings = settings;
  // --at is about what the command line names.
  if (std::exchange(opened_any_, true)) options.at.reset();
  Stage::Options stage = stage_options(options);
  stage.size = size;
  stage.on_ready = on_ready_;
  stage.reel.time = audio_.time();
  stage.source.sound = options.audio;
  opening_.emplace(
      opened_, std::move(stage),
      [options, size](const Box& bounds, Up up) { return first_camera(options, bounds, up, size); },
      [this, sources = opened_](std::size_t source, std::uint32_t frame, const Error& error) {
        errors_.broken(source,
                       sources.size() > 1 ? without_secrets(sources[source].where) + ": " : "",
                       frame, error);
      });
}

std::optional<Opening::Opened> WindowSession::take_opened() {
  if (!opening_) return std::nullopt;
  auto opened = opening_->poll();
  if (opened) opening_.reset();
  return opened;
}

void WindowSession::play(std::unique_ptr<Stage> stage) {
  audio_.begin(nullptr);
  retire(std::exchange(stage_, std::move(stage)));
  playing_.clear();
  for (std::size_t i = 0; stage_ && i < stage_->size(); ++i) {
    playing_.emplace_back();
    if (stage_->size() > 1) playing_.back().append(stage_->where(i)).append(": ");
  }
  audio_.begin(stage_.get());
}

bool WindowSession::has_frame() const {
  return stage_ && std::any_of(stage_->scene().begin(), stage_->scene().end(),
                               [](const PlacedFrame& placed) { return placed.frame != nullptr; });
}

std::string WindowSession::opened_names() const { return short_names(opened_); }

std::string WindowSession::playing_names() const {
  std::string names;
  for (std::size_t i = 0; stage_ && i < stage_->size(); ++i)
    names += (i > 0 ? ", " : "") + stage_->playback(i).name();
  return visible(names);
}

std::string WindowSession::waiting() const {
  if (opening_) {
    const auto trouble = opening_->trouble();
    return "Loading " + opened_names() +
           (trouble ? "\n" + visible(*trouble) + "; ESC gives up" : "");
  }
  return stage_ && !has_frame() ? "Waiting for the first picture" : "";
}

double WindowSession::waiting_seconds(TimePoint now) const {
  return std::chrono::duration<double>(now - opening_since_).count();
}

}  // namespace pointreel
