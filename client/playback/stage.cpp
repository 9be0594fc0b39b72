#include "client/playback/stage.h"

#include <algorithm>
#include <mutex>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "client/scene/view_box.h"
#include "client/source/folder_source.h"
#include "client/source/open_live_source.h"
#include "client/source/open_source.h"
#include "codec/files/cloud_file.h"
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

/// Playback begins within at least one of the reels.
Result<void> check_start(const std::vector<std::unique_ptr<Source>>& reels,
                         const std::vector<Stage::Placed>& sources, std::uint64_t start_us) {
  std::optional<std::size_t> longest;
  const auto end_of = [&](std::size_t i) { return reels[i]->manifest().duration_us; };
  for (std::size_t i = 0; i < reels.size(); ++i)
    if (reels[i] && (!longest || end_of(i) > end_of(*longest))) longest = i;
  if (!longest || start_us <= end_of(*longest)) return {};
  const auto seconds = [](std::uint64_t us) { return number_text(static_cast<double>(us) / 1e6); };
  return fail(ErrorCode::argument,
              fmt::format("{}: ends at {} s, before {} s, where --at says to begin",
                          sources[*longest].where, seconds(end_of(*longest)), seconds(start_us)));
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
    const std::vector<std::filesystem::path>& files = sources[i].files;
    if (files.empty() && is_live_address(where)) {
      streams[i] = TRY(open_live_source(where, source_options));
      continue;
    }
    reels[i] = TRY(files.empty() ? open_source(where, source_options)
                                 : open_file_sequence(files, source_options));
    if (reels[i]->manifest().frame_count() == 0) return fail(where + ": the reel has no frames");
    grow(bounds, reels[i]->manifest().bounds, sources[i].place);
  }
  TRY(check_start(reels, sources, options.reel.start_us));
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
    Part part{sources[i].where, sources[i].place, {}, {}, {}};
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
  std::optional<Error> first;
  for (const Part& part : parts_) {
    auto why = part.live() != nullptr ? part.live()->refusal() : std::nullopt;
    if (!why) return std::nullopt;
    if (!first) first = std::move(why);
  }
  return first;
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
