#include "client/playback/stage.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "client/scene/view_box.h"
#include "client/source/folder_source.h"
#include "client/source/open_live_source.h"
#include "client/source/open_source.h"
#include "codec/files/cloud_folder.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

void grow(Box& box, const Box& other, const glm::dvec3& place) {
  if (other.empty()) return;
  box.grow(other.min + place);
  box.grow(other.max + place);
}

Camera moved(Camera camera, const glm::dvec3& place) {
  camera.target -= place;
  return camera;
}

constexpr std::string_view kLivePath = "/live/";

/// NAME of .../live/NAME or .../live/NAME/reel.json.
std::string stream_name(const std::string& address) {
  const std::size_t begin = address.find(kLivePath);
  if (begin == std::string::npos) return address;
  const std::string name = address.substr(begin + kLivePath.size());
  return name.substr(0, name.find_first_of("/?#"));
}

/// Playback begins within at least one of the reels. Those that end before show their last frame,
/// which `say` is told.
Result<void> check_start(const std::vector<std::unique_ptr<Source>>& reels,
                         const std::vector<Stage::Placed>& sources, std::uint64_t start_us,
                         const std::function<void(const std::string&)>& say) {
  const auto seconds = [](std::uint64_t us) { return number_text(static_cast<double>(us) / 1e6); };
  std::vector<std::string> too_short;
  std::size_t count = 0;
  for (std::size_t i = 0; i < reels.size(); ++i) {
    if (!reels[i]) continue;
    ++count;
    if (const std::uint64_t end_us = reels[i]->manifest().duration_us; end_us < start_us)
      too_short.push_back(fmt::format("{}: ends at {} s, before {} s, where --at says to begin",
                                      without_secrets(sources[i].where), seconds(end_us),
                                      seconds(start_us)));
  }
  if (!too_short.empty() && too_short.size() == count)
    return fail(ErrorCode::argument, too_short.front());
  for (const std::string& line : too_short)
    if (say) say("warning: " + line + "; its last frame is shown");
  return {};
}

/// Recordings that were captured in part at the same time, as of one meeting, all start together:
/// `say` is told how to show them as they were.
void tell_apart(const std::vector<std::unique_ptr<Source>>& reels,
                const std::vector<Stage::Placed>& sources,
                const std::function<void(const std::string&)>& say) {
  constexpr std::uint64_t kTogether = 50'000;
  std::optional<std::size_t> last;  // the reel that was captured last
  for (std::size_t i = 0; i < reels.size(); ++i) {
    if (!reels[i] || !reels[i]->manifest().captured_us) continue;
    if (!last || *reels[i]->manifest().captured_us > *reels[*last]->manifest().captured_us)
      last = i;
  }
  for (std::size_t i = 0; last && say && i < reels.size(); ++i) {
    if (!reels[i] || !reels[i]->manifest().captured_us) continue;
    const Manifest& manifest = reels[i]->manifest();
    const std::uint64_t later = *reels[*last]->manifest().captured_us - *manifest.captured_us;
    if (later < kTogether || later >= manifest.duration_us) continue;
    const std::string name = without_secrets(sources[i].where);
    say(fmt::format(
        "warning: {}: was captured {:.3f} s after {}, but both start together; "
        "\"pointreel-server cut {} NEW --from {:.3f}\" makes a reel that begins with it",
        without_secrets(sources[*last].where), 1e-6 * static_cast<double>(later), name, name,
        1e-6 * static_cast<double>(later)));
  }
}

}  // namespace

struct Stage::Listener {
  std::mutex mutex;
  OnError on_error;
  Playback::OnReady on_ready;

  void failed(std::size_t source, std::uint32_t frame, const Error& error) {
    const std::lock_guard lock(mutex);
    if (on_error) on_error(source, frame, error);
  }
  void ready() {
    const std::lock_guard lock(mutex);
    if (on_ready) on_ready();
  }
};

bool is_live_address(const std::string& where) {
  const auto url = parse_url(where);
  if (!url) return false;
  return url->is_websocket() ||
         (url->is_http() &&
          url->target.substr(0, url->target.find('?')).find(kLivePath) != std::string::npos);
}

Result<std::unique_ptr<Stage>> Stage::open(const std::vector<Placed>& sources,
                                           const Options& options, const CameraFor& camera_for,
                                           OnError on_error) {
  const auto listener = std::make_shared<Listener>();
  listener->on_error = std::move(on_error);
  listener->on_ready = options.on_ready;
  const auto ready = [listener] { listener->ready(); };
  SourceOptions source_options = options.source;
  source_options.on_trouble = [listener, tell = options.source.on_trouble](const auto& line) {
    if (tell) tell(line);
    listener->ready();
  };
  std::vector<std::unique_ptr<Source>> reels(sources.size());
  std::vector<std::unique_ptr<LiveSource>> streams(sources.size());
  Box bounds;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::string& where = sources[i].where;
    source_options.token = sources[i].token.empty() ? options.source.token : sources[i].token;
    const std::vector<std::filesystem::path>& files = sources[i].files;
    if (files.empty() && is_live_address(where)) {
      streams[i] = TRY(open_live_source(where, source_options));
      continue;
    }
    reels[i] = TRY(files.empty() ? open_source(where, source_options)
                                 : open_file_sequence(files, source_options));
    if (reels[i]->manifest().frame_count() == 0)
      return fail(without_secrets(where) + ": the reel has no frames");
    grow(bounds, reels[i]->manifest().bounds, sources[i].place);
  }
  TRY(check_start(reels, sources, options.reel.start_us, source_options.say));
  tell_apart(reels, sources, source_options.say);
  const auto first_reel =
      std::find_if(reels.begin(), reels.end(), [](const auto& reel) { return reel != nullptr; });
  const Camera camera =
      camera_for(bounds, first_reel != reels.end() ? (*first_reel)->manifest().up : Up('y'));

  auto stage = std::make_unique<Stage>();
  stage->prepare_ = options.prepare;
  stage->listener_ = listener;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const auto failed = [i, listener](std::uint32_t frame, const Error& error) {
      listener->failed(i, frame, error);
    };
    Part part{without_secrets(sources[i].where), sources[i].place, {}, {}, {}};
    if (reels[i]) {
      ReelPlayback::Options reel = options.reel;
      reel.prepare = options.prepare;
      reel.remote = sources[i].files.empty() && !scheme_of(sources[i].where).empty();
      part.source = std::make_unique<ReelPlayback>(
          std::move(reels[i]), reel, moved(camera, part.place), options.size, failed, ready);
    } else {
      LivePlayback::Options live = options.live;
      live.prepare = options.prepare;
      part.source = std::make_unique<LivePlayback>(
          std::move(streams[i]), stream_name(sources[i].where), live, failed, ready);
    }
    stage->parts_.push_back(std::move(part));
    stage->scene_.push_back({nullptr, sources[i].place});
  }
  return stage;
}

Box Stage::bounds() const {
  Box all;
  for (const Part& part : parts_) grow(all, part.playback().bounds(), part.place);
  return all;
}

std::vector<std::string> Stage::scalar_names() const {
  std::vector<std::string> names;
  for (const Part& part : parts_)
    for (const ScalarRange& field : part.playback().scalars())
      if (std::find(names.begin(), names.end(), field.name) == names.end())
        names.push_back(field.name);
  return names;
}

Box Stage::Part::view_bounds() const { return view_box(playback().bounds(), first); }

Box Stage::view_bounds() const {
  Box all;
  for (const Part& part : parts_) grow(all, part.view_bounds(), part.place);
  return all;
}

std::size_t Stage::view_version() const {
  const auto bounded = std::count_if(parts_.begin(), parts_.end(), [](const Part& part) {
    return !part.playback().bounds().empty();
  });
  return first_boxes_ + static_cast<std::size_t>(bounded);
}

bool Stage::playing() const {
  return std::any_of(parts_.begin(), parts_.end(), [](const Part& part) {
    return std::visit([](const auto& source) { return source->playing(); }, part.source);
  });
}

double Stage::frame_seconds() const {
  double seconds = parts_.front().playback().frame_seconds();
  for (const Part& part : parts_) seconds = std::min(seconds, part.playback().frame_seconds());
  return seconds;
}

void Stage::set_live_playing(bool playing) {
  for (const Part& part : parts_) {
    if (LivePlayback* live = part.live()) playing ? live->play() : live->pause();
  }
}

void Stage::look(const Camera& camera, glm::ivec2 size) {
  for (Part& part : parts_) part.playback().look(moved(camera, part.place), size);
}

void Stage::set_prepare_options(const PrepareOptions& options) {
  prepare_ = options;
  for (Part& part : parts_) part.playback().set_prepare_options(options);
}

void Stage::silence() {
  const std::lock_guard lock(listener_->mutex);
  listener_->on_error = nullptr;
  listener_->on_ready = nullptr;
}

std::vector<Stage::Change> Stage::take(std::size_t source,
                                       std::shared_ptr<const SceneFrame> frame) {
  show(source, std::move(frame));
  return {{source, false}};
}

void Stage::show(std::size_t source, std::shared_ptr<const SceneFrame> frame) {
  Part& part = parts_[source];
  // From afar, a speck is decoded as a few cells, which are much larger than the frame. In more
  // detail it is smaller, or turns out to be a single place. Of a live stream, it may be another
  // frame that comes in more detail.
  if (!part.first_level || (part.first.rough && frame->level > *part.first_level)) {
    part.first_level = frame->level;
    part.first = frame->boxes;
    ++first_boxes_;
  }
  scene_[source].frame = std::move(frame);
}

Stage::Update Stage::update(Clock::TimePoint now) {
  Update update;
  update.ended = true;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Playback::Update one = parts_[i].playback().update(now);
    update.ended = update.ended && one.ended;
    if (one.due) update.due = std::min(*one.due, update.due.value_or(*one.due));
    if (!one.frame || one.frame == scene_[i].frame) continue;
    show(i, one.frame);
    update.changes.push_back({i, one.refined});
  }
  return update;
}

std::optional<Error> Stage::refusal() const {
  for (const Part& part : parts_) {
    auto why = part.live() != nullptr ? part.live()->refusal() : std::nullopt;
    if (why) return why;
  }
  return std::nullopt;
}

std::vector<Stage::Placed> sources_of(const std::vector<std::string>& paths) {
  std::vector<Stage::Placed> sources;
  std::vector<std::filesystem::path> files;
  std::size_t place = 0;  // index of the files among the sources
  for (const std::string& path : paths) {
    if (!is_cloud_file(path)) {
      sources.push_back({path});
      continue;
    }
    if (files.empty()) place = sources.size();
    files.emplace_back(path);
  }
  if (files.empty()) return sources;
  Stage::Placed sequence{files.front().string()};
  if (files.size() > 1) {
    sequence.where += fmt::format(" and {} more", files.size() - 1);
    sequence.files = std::move(files);
  }
  sources.insert(sources.begin() + static_cast<std::ptrdiff_t>(place), std::move(sequence));
  return sources;
}

}  // namespace pointreel
