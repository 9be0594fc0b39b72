#include "client/ui/play_statistics.h"

#include <algorithm>
#include <chrono>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "common/base/words.h"
#include "common/process/print.h"

namespace pointreel {
namespace {

constexpr std::chrono::seconds kRateTime{2};

std::string short_number(double value, double base, std::initializer_list<const char*> units) {
  auto unit = units.begin();
  while (value >= 0.9995 * base && unit + 1 != units.end()) {
    value /= base;
    ++unit;
  }
  if (unit == units.begin()) return fmt::format("{:.0f}{}", value, *unit);
  return fmt::format("{:.{}f}{}", value, value < 9.995 ? 2 : value < 99.95 ? 1 : 0, *unit);
}

/// The memory that this process occupies; 0 if that is not known.
std::uint64_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  if (!(in >> all >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

const char* reason(Limit limit) {
  switch (limit) {
    case Limit::none:
      return "these are all";
    case Limit::asked:
      return "no more were asked for";
    case Limit::view:
      return "the view needs no more";
    case Limit::link:
      return "the link is too slow for more";
    case Limit::machine:
      return "this machine is too slow for more";
  }
  return "";
}

std::string layers_text(const ReelPlayback& reel, const SceneFrame* frame) {
  const std::size_t all = reel.manifest().layer_names.size();
  if (all == 0) return "none, in files";
  const LayerDecision decision = reel.decision();
  const std::uint32_t shown = frame ? frame->layers : 0;
  std::string text = fmt::format("{} of {}", shown, all);
  if (shown != decision.layers.end)
    text += fmt::format(", {} in coming frames", decision.layers.end);
  return text + ": " + reason(decision.limit);
}

std::string tree_text(const SceneFrame& frame) {
  if (frame.svo.node_count() == 0) return fmt::format("{} points", short_count(frame.points));
  return fmt::format("{} points, {} leaves, depth {}", short_count(frame.points),
                     short_count(frame.svo.leaf_count()), frame.svo.depth);
}

std::string dropped_text(const Playback& playback) {
  std::string text = fmt::format("{}", playback.dropped());
  if (playback.errors() > 0) text += fmt::format(", {} broken", playback.errors());
  return text;
}

void add_reel(std::vector<StatisticsLine>& lines, const ReelPlayback& reel) {
  const ReelPlayback::Statistics statistics = reel.statistics();
  if (statistics.link_bits_per_second > 0.0)
    lines.push_back({"Link", fmt::format("{}bit/s, {:.1f} s buffered",
                                         short_count(statistics.link_bits_per_second) + " ",
                                         statistics.buffered_seconds)});
  lines.push_back({"Fetched", short_bytes(statistics.fetched_bytes)});
  if (statistics.stalls > 0)
    lines.push_back({"Stalled", fmt::format("{}, {:.1f} s", counted(statistics.stalls, "time"),
                                            statistics.stalled_seconds)});
  lines.push_back({"Buffers", fmt::format("{} ready, {} coded", short_bytes(statistics.frame_bytes),
                                          short_bytes(statistics.stored_bytes))});
}

void add_live(std::vector<StatisticsLine>& lines, const LiveCounts& counts) {
  lines.push_back({"Received", fmt::format("{}, {}", counted(counts.frames, "frame"),
                                           short_bytes(counts.bytes))});
  if (counts.dropped > 0)
    lines.push_back(
        {"Left out", fmt::format("{}, by the server", counted(counts.dropped, "layer"))});
  if (counts.reconnections > 0)
    lines.push_back({"Reconnected", counted(counts.reconnections, "time")});
}

std::string coarsening_text(const DraftCoarsening& coarsening) {
  if (coarsening.reduction > 1) return fmt::format(", 1/{} resolution", coarsening.reduction);
  return coarsening.pixel_size > 1.0f ? ", larger than asked" : "";
}

}  // namespace

const char* name(Step step) {
  constexpr std::array<const char*, kSteps.size()> names = {"fetch", "decode", "tree", "cut",
                                                            "draw"};
  return names[static_cast<std::size_t>(step)];
}

void RecentFrames::add(const SceneFrame& frame, const DrawStats& drawn, Clock::TimePoint now) {
  Sample& sample = samples_[next_];
  sample.ms = {static_cast<float>(frame.fetch_ms), static_cast<float>(frame.decode_ms),
               static_cast<float>(frame.normals_ms + frame.svo_ms),
               static_cast<float>(drawn.cut_ms), static_cast<float>(drawn.render_ms)};
  sample.shown = now;
  next_ = (next_ + 1) % kMaxFrames;
  count_ = std::min(count_ + 1, kMaxFrames);
  drawn_ = drawn;
}

const RecentFrames::Sample& RecentFrames::sample(std::size_t i) const {
  return samples_[(next_ + kMaxFrames - count_ + i) % kMaxFrames];
}

std::vector<float> RecentFrames::times(Step step) const {
  std::vector<float> times;
  for (std::size_t i = 0; i < count_; ++i)
    times.push_back(sample(i).ms[static_cast<std::size_t>(step)]);
  return times;
}

double RecentFrames::frames_per_second(Clock::TimePoint now) const {
  std::size_t frames = 0;
  Clock::TimePoint first = now;
  for (std::size_t i = count_; i > 0 && now - sample(i - 1).shown <= kRateTime; --i) {
    ++frames;
    first = sample(i - 1).shown;
  }
  if (frames < 2) return 0.0;
  // Up to the last frame that was shown: the interval after it is not over yet.
  const double seconds = std::chrono::duration<double>(sample(count_ - 1).shown - first).count();
  return seconds > 0.0 ? static_cast<double>(frames - 1) / seconds : 0.0;
}

std::string short_count(double count) {
  return short_number(count, 1000.0, {"", " k", " M", " G"});
}

std::string short_bytes(std::uint64_t bytes) {
  return short_number(static_cast<double>(bytes), 1024.0, {" B", " KiB", " MiB", " GiB"});
}

std::vector<StatisticsLine> statistics_lines(const Stage& stage, const RecentFrames& recent,
                                             Clock::TimePoint now) {
  std::vector<StatisticsLine> lines;
  lines.push_back({"Shown", fmt::format("{:.1f} frames/s", recent.frames_per_second(now))});
  const DrawStats& drawn = recent.drawn();
  lines.push_back({"Drawn", fmt::format("{} elements{}", short_count(drawn.drawn),
                                        coarsening_text(drawn.coarsening))});
  std::string left_out;
  const auto leave_out = [&](std::uint32_t count, const char* why) {
    if (count > 0)
      left_out += fmt::format("{}{} {}", left_out.empty() ? "" : ", ", short_count(count), why);
  };
  leave_out(drawn.out_of_view, "out of view");
  leave_out(drawn.below_pixel, "below a pixel");
  leave_out(drawn.hidden, "hidden");
  if (!left_out.empty()) lines.push_back({"Not drawn", left_out});
  for (std::size_t i = 0; i < stage.size(); ++i) {
    const Playback& playback = stage.playback(i);
    if (stage.size() > 1) lines.push_back({visible(playback.name()), ""});
    const SceneFrame* frame = stage.scene()[i].frame.get();
    if (frame) lines.push_back({"Frame", tree_text(*frame)});
    if (const ReelPlayback* reel = stage.reel(i))
      lines.push_back({"Layers", layers_text(*reel, frame)});
    else if (frame)
      lines.push_back({"Layers", fmt::format("{}", frame->layers)});
    lines.push_back({"Dropped", dropped_text(playback)});
    if (const ReelPlayback* reel = stage.reel(i)) add_reel(lines, *reel);
    if (const LivePlayback* live = stage.live(i)) add_live(lines, live->counts());
  }
  if (const std::uint64_t bytes = resident_bytes(); bytes > 0)
    lines.push_back({"Memory", short_bytes(bytes)});
  return lines;
}

}  // namespace pointreel
