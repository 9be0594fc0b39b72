#include "client/source/http_live_source.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "client/source/live_assembler.h"
#include "client/source/live_pacing.h"
#include "codec/live/live.h"
#include "codec/live/live_sound.h"
#include "codec/package/http_folder.h"
#include "common/base/try.h"
#include "common/http/http_client.h"
#include "common/threads/without_exceptions.h"
#include "pointreel/package.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using Time = LivePacing::Time;

/// The time between two requests for the manifest; there are a few during each segment.
constexpr milliseconds kShortestPoll{50}, kLongestPoll{500};
constexpr int kPollsPerSegment = 4;
/// A segment that took longer than this, and than four times its own length, is not shown.
constexpr std::chrono::seconds kTooLate{2};
/// The most frames, and bytes, that wait to be shown; beyond that the oldest are dropped.
constexpr std::size_t kMostWaiting = 512;
constexpr std::uint64_t kMostWaitingBytes = 256u << 20;
/// Pictures wait for sound that comes this much later, in microseconds, but for no later one.
constexpr std::uint64_t kMostSoundLag = 500'000;
/// How many segments must come in less than half of their length before another layer is tried.
constexpr int kQuickBeforeMore = 4;

/// A frame of a segment that has come. It waits for its time.
struct WaitingFrame {
  Time due;
  std::uint32_t number = 0, points = 0;
  std::uint64_t capture_us = 0;
  std::uint8_t layers_sent = 1;
  std::vector<FetchedLayer> layers;

  std::uint64_t size() const {
    std::uint64_t bytes = 0;
    for (const FetchedLayer& layer : layers) bytes += layer.bytes.size();
    return bytes;
  }
};

std::chrono::microseconds length_of(const Segment& segment, double fps) {
  constexpr double kLongestFrameUs = 3.6e9;  // however low the rate is
  return std::chrono::microseconds(
      segment.times_us.back() - segment.times_us.front() +
      static_cast<std::uint64_t>(std::min(1e6 / fps, kLongestFrameUs)));
}

/// How many layers to fetch, judged by how long segments took to come.
class LayerBudget {
 public:
  std::size_t layers(std::size_t all) const { return std::min(layers_, all); }

  void took(std::chrono::duration<double> time, std::chrono::duration<double> length,
            std::size_t all) {
    layers_ = layers(all);
    if (time > length) {
      layers_ = std::max<std::size_t>(1, layers_ - 1);
      quick_ = 0;
    } else if (2.0 * time > length) {
      quick_ = 0;
    } else if (++quick_ >= kQuickBeforeMore) {
      ++layers_;
      quick_ = 0;
    }
  }

 private:
  std::size_t layers_ = ~std::size_t{0};
  int quick_ = 0;
};

class HttpLiveSource : public LiveSource {
 public:
  HttpLiveSource(HttpFolder folder, const SourceOptions& options)
      : folder_(std::move(folder)),
        with_sound_(options.sound),
        on_trouble_(options.on_trouble),
        client_(options) {
    fetcher_ = std::jthread([this] { fetch(); });
    try {
      pacer_ = std::jthread([this] { pace(); });
    } catch (...) {
      HttpLiveSource::cancel();  // or else the other thread goes on
      throw;
    }
  }
  ~HttpLiveSource() override { HttpLiveSource::cancel(); }

  std::optional<LiveHello> hello(milliseconds timeout) override {
    return assembler_.hello(timeout);
  }
  std::optional<LiveFrame> next(milliseconds timeout) override { return assembler_.next(timeout); }
  LiveCounts counts() const override {
    LiveCounts counts = assembler_.counts();
    counts.skipped += left_out_;
    return counts;
  }

  void set_on_sound(OnSound on_sound) override {
    const std::lock_guard lock(sound_mutex_);
    on_sound_ = std::move(on_sound);
  }

  std::optional<Error> refusal() const override {
    const std::lock_guard lock(mutex_);
    return refusal_;
  }

  std::optional<std::string> trouble() const override {
    if (auto link = client_.trouble()) return link;
    const std::lock_guard lock(mutex_);
    return trouble_;
  }

  void cancel() override {
    {
      const std::lock_guard lock(mutex_);
      stop_.request_stop();
    }
    client_.cancel();
    assembler_.cancel();
    changed_.notify_all();
  }

 private:
  void fetch() {
    std::string tag;
    auto pause = kLongestPoll;
    while (!stop_.stop_requested()) {
      const auto text =
          client_.get_if_changed(folder_.manifest(), kMaxManifestBytes, tag, stop_.get_token());
      if (!text) {
        if (stop_.stop_requested()) return;
        if (!session_ && text.error().code == ErrorCode::refused) return refused(text.error());
        set_trouble(text.error().message + "; waiting");
      } else if (*text) {
        auto manifest =
            parse_manifest({reinterpret_cast<const char*>((*text)->data()), (*text)->size()});
        if (!manifest)
          set_trouble(folder_.base + ": " + manifest.error().message);
        else if (!manifest->live)
          set_trouble(folder_.base + ": is a package, not a live stream");
        else if (const auto next =
                     without_exceptions([&]() -> Result<milliseconds> { return take(*manifest); }))
          pause = *next;
        else
          set_trouble(folder_.base + ": " + next.error().message);
      }
      wait(pause);
    }
  }

  void refused(const Error& error) {
    {
      const std::lock_guard lock(mutex_);
      refusal_ = error;
    }
    set_trouble(error.message);
    assembler_.cancel();
  }

  /// Fetches what is new in the manifest. Returns how long to wait before the next request for it.
  milliseconds take(const Manifest& manifest) {
    const LiveManifest& live = *manifest.live;
    {
      // Once a new publisher is known, nothing of the one before it may be shown.
      const std::lock_guard lock(mutex_);
      if (session_ != live.session) {
        session_ = live.session;
        newest_us_ = 0;
        next_number_ = 0;
        pacing_.reset();
        waiting_.clear();
        waiting_bytes_ = 0;
      }
      assembler_.add(LiveHello{manifest, live.session, manifest.bounds, {}});
    }
    if (live.ended)
      set_trouble(folder_.base + ": the publisher has gone; waiting for it");
    else
      set_trouble(std::nullopt);
    if (manifest.segments.empty()) return kShortestPoll;

    // Segments are told apart by the time of their capture: a server that was started again numbers
    // them anew.
    const auto is_new = [&](const Segment& segment) {
      return live.start_us + segment.times_us.back() > newest_us_;
    };
    auto first = std::find_if(manifest.segments.begin(), manifest.segments.end(), is_new);
    if (newest_us_ == 0) first = manifest.segments.end() - 1;
    // What a cache holds back for a while comes late, but all of it is shown; what is later than
    // that is left out, so that the delay does not grow.
    const auto length = length_of(manifest.segments.back(), manifest.fps);
    const auto is_late = [&](const Segment& segment) {
      const auto behind = std::chrono::microseconds(manifest.segments.back().times_us.back() -
                                                    segment.times_us.back());
      return behind > std::max<std::chrono::microseconds>(kTooLate, length);
    };
    for (; first != manifest.segments.end() && is_late(*first); ++first)
      left_out_ += first->frame_count();
    for (auto segment = first; segment != manifest.segments.end(); ++segment)
      if (!is_new(*segment) || !fetch_segment(manifest, *segment)) break;
    return std::clamp(std::chrono::duration_cast<milliseconds>(length) / kPollsPerSegment,
                      kShortestPoll, kLongestPoll);
  }

  bool fetch_segment(const Manifest& manifest, const Segment& segment) {
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t layers = budget_.layers(segment.layers.size());
    std::vector<HttpClient::Range> ranges;
    for (std::size_t i = 0; i < layers; ++i) {
      const LayerFile& file = segment.layers[i];
      if (file.bytes > kMostWaitingBytes) return false;
      if (file.bytes > 0) ranges.push_back({folder_.file(file.path), 0, file.bytes, file.bytes});
    }
    const bool with_sound = with_sound_ && segment.sound && segment.sound->bytes > 0;
    if (with_sound) {
      const PackageFile& file = *segment.sound;
      ranges.push_back({folder_.file(file.path), 0, file.bytes, file.bytes});
    }
    auto files = client_.get_ranges(ranges, stop_.get_token());
    // It is not requested again even if it failed: a cache may have dropped it, and there are newer
    // segments.
    const std::uint64_t shown_us = newest_us_;
    newest_us_ = manifest.live->start_us + segment.times_us.back();
    if (!files) {
      left_out_ += segment.frame_count();
      return false;
    }
    const auto now = std::chrono::steady_clock::now();
    const auto length = length_of(segment, manifest.fps);
    budget_.took(now - begin, length, segment.layers.size());
    // After the connection was lost for a while a segment is outdated when it comes, and does not
    // tell how long the next ones will take.
    if (now - begin > std::max<std::chrono::microseconds>(kTooLate, 4 * length)) {
      left_out_ += segment.frame_count();
      return false;
    }
    std::uint64_t begin_us = manifest.live->start_us + segment.times_us.front();
    if (with_sound) {
      begin_us = play_sound(*segment.sound, files->back(), begin_us);
      files->pop_back();  // the rest are layers
    }
    pacing_.arrived(begin_us, now);
    cut_up(manifest, segment,
           {std::make_move_iterator(files->begin()), std::make_move_iterator(files->end())},
           shown_us);
    return true;
  }

  /// Passes the packets of a segment on whose first frame was captured at `begin_us`. Returns when
  /// it would have been captured to be shown in time for them, if pictures without sound are shown
  /// as soon as they come: sound may come later than its picture, and has to come before it is
  /// heard.
  std::uint64_t play_sound(const PackageFile& file, ByteView bytes, std::uint64_t begin_us) {
    const bool whole = checksum_of(bytes) == file.checksum;
    const auto sounds = parse_live_sound_file(whole ? bytes : ByteView());
    if (!whole || !sounds) {
      assembler_.add_bad();
      return begin_us;
    }
    const std::lock_guard lock(sound_mutex_);
    if (!on_sound_ || sounds->empty()) return begin_us;
    for (const LiveSound& sound : *sounds) on_sound_(sound);
    const std::uint64_t first_us = std::min(begin_us, sounds->front().capture_us);
    return std::max(first_us, begin_us - std::min(begin_us, kMostSoundLag)) -
           static_cast<std::uint64_t>(kSoundLead.count());
  }

  /// Queues the frames of a segment's files that were captured after `shown_us`.
  void cut_up(const Manifest& manifest, const Segment& segment,
              const std::vector<SharedBytes>& files, std::uint64_t shown_us) {
    std::deque<WaitingFrame> frames;
    for (std::uint32_t i = 0; i < segment.frame_count(); ++i) {
      WaitingFrame frame;
      frame.points = segment.points[i];
      frame.capture_us = manifest.live->start_us + segment.times_us[i];
      if (frame.capture_us <= shown_us) continue;
      frame.number = next_number_++;
      frame.due = pacing_.due(frame.capture_us);
      std::size_t file = 0, sent = 0;
      for (const LayerFile& layer : segment.layers) {
        if (layer.frames[i].geometry == 0) break;
        ++sent;
        if (file >= files.size()) continue;
        const ByteRange range = byte_range(layer, i);
        frame.layers.push_back({files[file].part(range.offset, range.size), layer.frames[i]});
        ++file;
      }
      frame.layers_sent = static_cast<std::uint8_t>(sent);
      if (!frame.layers.empty()) frames.push_back(std::move(frame));
    }
    {
      const std::lock_guard lock(mutex_);
      for (WaitingFrame& frame : frames) {
        waiting_bytes_ += frame.size();
        waiting_.push_back(std::move(frame));
      }
      while (waiting_.size() > kMostWaiting ||
             (waiting_.size() > 1 && waiting_bytes_ > kMostWaitingBytes)) {
        waiting_bytes_ -= waiting_.front().size();
        waiting_.pop_front();
        ++left_out_;
      }
    }
    changed_.notify_all();
  }

  void pace() {
    std::unique_lock lock(mutex_);
    while (!stop_.stop_requested()) {
      if (waiting_.empty()) {
        changed_.wait(lock);
      } else if (const Time due = waiting_.front().due; std::chrono::steady_clock::now() < due) {
        changed_.wait_until(lock, due);
      } else {
        show(waiting_.front());
        waiting_bytes_ -= waiting_.front().size();
        waiting_.pop_front();
      }
    }
  }

  void show(const WaitingFrame& frame) {
    for (std::size_t i = 0; i < frame.layers.size(); ++i) {
      const FetchedLayer& layer = frame.layers[i];
      assembler_.add(LiveLayer{frame.number, static_cast<std::uint8_t>(i), frame.layers_sent,
                               frame.capture_us, frame.points, layer.sizes, layer.bytes.view()},
                     layer.bytes);
    }
  }

  void set_trouble(const std::optional<std::string>& text) {
    {
      const std::lock_guard lock(mutex_);
      if (text == trouble_) return;
      trouble_ = text;
    }
    if (on_trouble_) on_trouble_(text);
  }

  void wait(milliseconds pause) {
    std::unique_lock lock(mutex_);
    const auto until = std::chrono::steady_clock::now() + pause;
    changed_.wait_until(lock, until, [&] { return stop_.stop_requested(); });
  }

  const HttpFolder folder_;
  const bool with_sound_;
  const std::function<void(const std::optional<std::string>&)> on_trouble_;
  HttpClient client_;
  LiveAssembler assembler_;
  std::stop_source stop_;
  std::atomic<std::uint64_t> left_out_{0};  ///< frames that came too late to be shown

  // Only the fetching thread uses what follows.
  std::optional<std::uint64_t> session_;
  std::uint64_t newest_us_ = 0;  ///< frames captured until then have come, or are lost
  std::uint32_t next_number_ = 0;
  LivePacing pacing_;
  LayerBudget budget_;

  std::mutex sound_mutex_;
  OnSound on_sound_;

  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  std::optional<std::string> trouble_;
  std::optional<Error> refusal_;
  std::deque<WaitingFrame> waiting_;
  std::uint64_t waiting_bytes_ = 0;
  std::jthread fetcher_, pacer_;
};

}  // namespace

Result<std::unique_ptr<LiveSource>> open_http_live_source(const std::string& url,
                                                          const SourceOptions& options) {
  return std::make_unique<HttpLiveSource>(TRY(parse_http_folder(url)), options);
}

}  // namespace pointreel
