#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "client/playback/clock.h"
#include "client/playback/stage.h"
#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"

namespace pointreel {

/// The steps that it takes to show a frame, in their order.
enum class Step { fetch, decode, tree, cut, draw };
inline constexpr std::array<Step, 5> kSteps = {Step::fetch, Step::decode, Step::tree, Step::cut,
                                               Step::draw};
/// "fetch", "decode", "tree", "cut", "draw".
const char* name(Step step);

/// The times of the last frames shown, for the statistics panel.
class RecentFrames {
 public:
  static constexpr std::size_t kMaxFrames = 120;

  /// Adds a frame that was drawn for the first time.
  void add(const SceneFrame& frame, const DrawStats& drawn, Clock::TimePoint now);
  /// The newest frame was drawn again, for another camera or with more pixels.
  void redrawn(const DrawStats& drawn) { drawn_ = drawn; }
  void clear() { *this = {}; }

  std::size_t size() const { return count_; }
  /// The milliseconds that the step took for each frame, the oldest first.
  std::vector<float> times(Step step) const;
  /// Over the last two seconds, or since the first frame.
  double frames_per_second(Clock::TimePoint now) const;
  const DrawStats& drawn() const { return drawn_; }  ///< of the newest

 private:
  struct Sample {
    std::array<float, kSteps.size()> ms{};
    Clock::TimePoint shown{};
  };
  const Sample& sample(std::size_t i) const;  ///< 0: the oldest

  std::array<Sample, kMaxFrames> samples_{};
  std::size_t next_ = 0, count_ = 0;
  DrawStats drawn_;
};

/// A figure for the statistics panel.
struct StatisticsLine {
  std::string label, text;

  bool operator==(const StatisticsLine&) const = default;
};

/// The frame rate, the elements drawn and memory, and for each source its layers and the reason for
/// their number, dropped frames, and its link or live stream.
std::vector<StatisticsLine> statistics_lines(const Stage& stage, const RecentFrames& recent,
                                             Clock::TimePoint now);

/// "847", "61.0 k", "1.23 M".
std::string short_count(double count);
/// "847 B", "61.0 KiB", "1.23 MiB".
std::string short_bytes(std::uint64_t bytes);

}  // namespace pointreel
