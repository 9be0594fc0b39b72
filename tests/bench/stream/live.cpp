#include "tests/bench/stream/live.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <fmt/format.h>

#include "client/playback/live_playback.h"
#include "client/source/live_source.h"
#include "client/source/open_live_source.h"
#include "codec/live/live.h"
#include "codec/octree/frame_header.h"
#include "common/base/try.h"
#include "common/base/unix_time.h"
#include "common/net/websocket.h"
#include "tests/bench/program.h"
#include "tests/e2e/server_address.h"
#include "tests/link/link_emulator.h"
#include "tests/load/load_generator.h"

namespace pointreel::bench {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;
using Time = std::chrono::steady_clock::time_point;
namespace fs = std::filesystem;

constexpr const char* kPublishedFps = "30";
constexpr unsigned kOthers = 49;
/// A viewer counts as live again when a picture is at most this late.
constexpr double kLiveMs = 100.0;
constexpr auto kLook = 1ms;

double unix_ms() { return static_cast<double>(unix_time_us()) / 1000.0; }

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 1e9;
  std::sort(values.begin(), values.end());
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(at, values.size() - 1)];
}

json spread(const std::vector<double>& values) {
  return {{"count", values.size()},
          {"median", quantile(values, 0.5)},
          {"p95", quantile(values, 0.95)},
          {"p99", quantile(values, 0.99)}};
}

/// A server with a stream, and a publisher in a process of its own.
struct Stage {
  std::unique_ptr<e2e::Background> server, publisher;
  std::string address;

  Result<void> begin(const fs::path& frames) {
    server = std::make_unique<e2e::Background>(
        "pointreel-server", std::vector<std::string>{"serve", "--live", "--listen", "127.0.0.1:0"});
    address = e2e::server_address(*server);
    if (address.empty()) return fail(ErrorCode::io, "pointreel-server: did not start");
    publisher = std::make_unique<e2e::Background>(
        "pointreel-server",
        std::vector<std::string>{"publish", "-i", frames.string(), "--loop", "--fps", kPublishedFps,
                                 "--to", "ws://" + address + "/live/stage"});
    return {};
  }
};

/// Receives the pictures that a player would show.
class Watcher {
 public:
  static Result<std::unique_ptr<Watcher>> open(const std::string& address) {
    auto source = TRY(open_live_source("ws://" + address + "/live/stage", {}));
    auto watcher = std::unique_ptr<Watcher>(new Watcher(std::move(source)));
    if (!watcher->next(20s)) return fail(ErrorCode::io, "no live picture came within 20 s");
    return watcher;
  }

  /// Waits for the next picture and returns its age in milliseconds; nothing after `timeout`.
  std::optional<double> next(std::chrono::milliseconds timeout) {
    for (const Time end = std::chrono::steady_clock::now() + timeout;
         std::chrono::steady_clock::now() < end;) {
      const Playback::Update update = playback_.update(std::chrono::steady_clock::now());
      if (update.frame && update.frame->time_us != last_us_) {
        last_us_ = update.frame->time_us;
        return unix_ms() - 1e-3 * static_cast<double>(last_us_);
      }
      Camera camera;
      camera.up = playback_.up();
      camera.frame_bounds(playback_.bounds(), 16.0 / 9.0);
      playback_.look(camera, {1280, 720});
      std::this_thread::sleep_for(kLook);
    }
    return std::nullopt;
  }

 private:
  explicit Watcher(std::unique_ptr<LiveSource> source)
      : playback_(std::move(source), "stage", options(), {}) {}

  static LivePlayback::Options options() {
    LivePlayback::Options options;
    options.prepare.mode = DrawMode::surfel;
    return options;
  }

  LivePlayback playback_;
  std::uint64_t last_us_ = 0;
};

/// The median depth of the frames of one second. The publisher reduces the depth if it would
/// otherwise be late.
double depth_now(const std::string& address) {
  const auto socket = WebSocket::connect("ws://" + address + "/live/stage");
  std::vector<double> depths;
  while (socket && depths.size() < 30) {
    const auto message = (*socket)->receive(1s);
    if (!message || !*message) break;
    if ((*message)->kind != WebSocket::Kind::binary) continue;
    const auto layer = parse_live_layer((*message)->bytes);
    if (!layer || layer->layer > 0) continue;
    if (const auto header = read_frame_header(layer->bytes)) depths.push_back(header->header.depth);
  }
  return depths.empty() ? 0.0 : quantile(depths, 0.5);
}

Result<json> capture_to_picture(const Stage& stage, const StreamOptions& options,
                                std::vector<Bar>& bars) {
  const auto watcher = TRY(Watcher::open(stage.address));
  const auto seconds = options.quick ? 3s : 15s;
  const Time warm = std::chrono::steady_clock::now() + 2s, end = warm + seconds;
  std::vector<double> delays;
  for (Time now = {}; (now = std::chrono::steady_clock::now()) < end;) {
    const std::optional<double> delay = watcher->next(1s);
    if (delay && now > warm) delays.push_back(*delay);
  }
  bars.push_back({"live at 30 frames per second: capture to picture, 95 %", quantile(delays, 0.95),
                  "ms", 100.0});
  json figures = spread(delays);
  figures["pictures_per_second"] =
      static_cast<double>(delays.size()) / std::chrono::duration<double>(seconds).count();
  figures["depth"] = depth_now(stage.address);
  return figures;
}

Result<json> back_to_live(const Stage& stage, const StreamOptions& options,
                          std::vector<Bar>& bars) {
  const auto link = TRY(LinkEmulator::start({.target = stage.address}));
  const auto watcher = TRY(Watcher::open(link->address()));
  std::vector<double> times;
  for (int i = 0; i < (options.quick ? 1 : 5); ++i) {
    for (int frame = 0; frame < 30; ++frame) watcher->next(1s);
    LinkConditions cut;
    cut.cut = true;
    link->set(cut);
    const Time until = std::chrono::steady_clock::now() + (options.quick ? 3s : 10s);
    while (std::chrono::steady_clock::now() < until) watcher->next(50ms);
    link->set({});
    const Time restored = std::chrono::steady_clock::now();
    const Time give_up = restored + 30s;
    while (std::chrono::steady_clock::now() < give_up) {
      const std::optional<double> delay = watcher->next(100ms);
      if (delay && *delay <= kLiveMs) break;
    }
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - restored)
            .count());
  }
  bars.push_back(
      {"live: until live again after a stall of 10 s, median", quantile(times, 0.5), "ms", 500.0});
  return json{{"ms", times}};
}

/// A viewer at 1 Mbit/s, in a thread of its own.
class SlowViewer {
 public:
  static Result<std::unique_ptr<SlowViewer>> start(const std::string& address) {
    LinkConditions slow;
    slow.bits_per_second = 1'000'000;
    auto link = TRY(LinkEmulator::start({.target = address, .conditions = slow}));
    WebSocketOptions patient;
    patient.silence_timeout = 30s;
    auto socket = TRY(WebSocket::connect("ws://" + link->address() + "/live/stage", patient));
    return std::unique_ptr<SlowViewer>(new SlowViewer(std::move(link), std::move(socket)));
  }
  ~SlowViewer() {
    socket_->close();
    thread_.join();
  }

  LiveDrops drops() const { return {dropped_frames_.load(), dropped_layers_.load()}; }
  std::uint64_t bases() const { return bases_; }

 private:
  SlowViewer(std::unique_ptr<LinkEmulator> link, std::unique_ptr<WebSocket> socket)
      : link_(std::move(link)), socket_(std::move(socket)), thread_([this] { run(); }) {}

  void run() {
    for (;;) {
      const auto message = socket_->receive(1s);
      if (!message) return;
      if (!*message) continue;
      const Bytes& bytes = (*message)->bytes;
      if ((*message)->kind == WebSocket::Kind::binary) {
        const auto layer = parse_live_layer(bytes);
        bases_ += layer && layer->layer == 0 ? 1 : 0;
      } else if (const auto text =
                     parse_live_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()})) {
        if (const auto* drops = std::get_if<LiveDrops>(&*text)) {
          dropped_frames_ = drops->frames;
          dropped_layers_ = drops->layers;
        }
      }
    }
  }

  const std::unique_ptr<LinkEmulator> link_;
  const std::unique_ptr<WebSocket> socket_;
  std::atomic<std::uint64_t> bases_{0}, dropped_frames_{0}, dropped_layers_{0};
  std::thread thread_;
};

Result<json> one_slow_viewer(const Stage& stage, const StreamOptions& options,
                             std::vector<Bar>& bars) {
  LoadOptions load;
  load.url = "ws://" + stage.address + "/live/stage";
  load.viewers = kOthers;
  load.seconds = options.quick ? 2.0 : 5.0;
  // Both measurements take turns, so that a change of the machine's load affects both.
  std::vector<double> without, with;
  json slow_figures;
  for (int i = 0; i < (options.quick ? 1 : 5); ++i) {
    without.push_back(TRY(pointreel::run_load(load)).delay_ms(0.95));
    const auto slow = TRY(SlowViewer::start(stage.address));
    with.push_back(TRY(pointreel::run_load(load)).delay_ms(0.95));
    slow_figures = {{"bases", slow->bases()},
                    {"dropped_frames", slow->drops().frames},
                    {"dropped_layers", slow->drops().layers}};
  }
  bars.push_back({"live: delay that one viewer at 1 Mbit/s adds to 49 others (95 % of frames)",
                  quantile(with, 0.5) - quantile(without, 0.5), "ms", 5.0});
  return json{{"p95_ms_without", without}, {"p95_ms_with", with}, {"slow_viewer", slow_figures}};
}

}  // namespace

Result<json> run_live(const StreamOptions& options, std::vector<Bar>& bars) {
  const fs::path frames = options.scratch / "live-frames";
  TRY(run_program("pointreel-synth",
                  {"soccer-shoot", "--frames", options.quick ? "6" : "60", "-o", frames.string()}));
  Stage stage;
  TRY(stage.begin(frames));
  // The publisher has started once its stream can be joined.
  for (int i = 0; i < 200 && !WebSocket::connect("ws://" + stage.address + "/live/stage"); ++i) {
    std::this_thread::sleep_for(100ms);
  }
  json report;
  struct Part {
    const char* name;
    Result<json> (*measure)(const Stage&, const StreamOptions&, std::vector<Bar>&);
  };
  for (const auto& [name, measure] : {Part{"capture_to_picture", capture_to_picture},
                                      {"back_to_live", back_to_live},
                                      {"one_slow_viewer", one_slow_viewer}}) {
    Result<json> figures = measure(stage, options, bars);
    if (!figures) return fail_at(name, figures.error());
    report[name] = std::move(*figures);
  }
  return report;
}

}  // namespace pointreel::bench
