#include "server/service/metrics.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <string_view>

#include <dirent.h>
#include <fmt/format.h>
#include <unistd.h>

namespace pointreel {
namespace {

class MetricsText {
 public:
  void begin(std::string_view name, std::string_view type, std::string_view help) {
    fmt::format_to(std::back_inserter(text_), "# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help);
    name_ = name;
  }
  /// `labels` is the text between the braces.
  void value(double value, std::string_view labels = {}) {
    fmt::format_to(std::back_inserter(text_), "{}{}{}{} {}\n", name_, labels.empty() ? "" : "{",
                   labels, labels.empty() ? "" : "}", value);
  }
  void one(std::string_view name, std::string_view type, std::string_view help, double number) {
    begin(name, type, help);
    value(number);
  }
  std::string text_;

 private:
  std::string_view name_;
};

double number(const Metrics::Count& count) {
  return static_cast<double>(count.load(std::memory_order_relaxed));
}

/// The Unix time in seconds at which this process was started, or nearly so: when its statics were
/// initialised.
const double kStartTime = static_cast<double>(std::time(nullptr));

void write_process(MetricsText& page) {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0, resident = 0;
  if (statm >> pages >> resident) {
    page.one("process_resident_memory_bytes", "gauge", "Resident memory size in bytes.",
             static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)));
  }
  // A directory_iterator ends the program if there is no memory for it.
  const auto close = [](DIR* folder) { ::closedir(folder); };
  if (const std::unique_ptr<DIR, decltype(close)> descriptors(::opendir("/proc/self/fd"));
      descriptors != nullptr) {
    int count = -2;  // "." and ".."
    while (::readdir(descriptors.get()) != nullptr) ++count;
    page.one("process_open_fds", "gauge", "Number of open file descriptors.", count);
  }
  timespec used{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  page.one("process_cpu_seconds_total", "counter", "Processor time spent in seconds.",
           static_cast<double>(used.tv_sec) + static_cast<double>(used.tv_nsec) * 1e-9);
  page.one("process_start_time_seconds", "gauge", "Unix time of the start in seconds.", kStartTime);
}

void write_streams(MetricsText& page, const std::vector<StreamStatistics>& streams) {
  const auto each = [&](std::string_view name, std::string_view type, std::string_view help,
                        auto value_of) {
    page.begin(name, type, help);
    // Names consist of letters, digits, '.', '_' and '-', so nothing needs to be escaped.
    for (const StreamStatistics& stream : streams) {
      page.value(static_cast<double>(value_of(stream)), fmt::format("stream=\"{}\"", stream.name));
    }
  };
  using S = const StreamStatistics&;
  each("pointreel_live_publishing", "gauge", "1 while the stream has a publisher.",
       [](S s) { return s.publishing ? 1 : 0; });
  each("pointreel_live_viewers", "gauge", "Viewers of the stream.", [](S s) { return s.viewers; });
  each("pointreel_live_frames_total", "counter", "Frames published.", [](S s) { return s.frames; });
  each("pointreel_live_layers_total", "counter", "Layers published.", [](S s) { return s.layers; });
  each("pointreel_live_bytes_total", "counter", "Bytes published.", [](S s) { return s.bytes; });
  each("pointreel_live_sent_bytes_total", "counter", "Bytes that viewers took.",
       [](S s) { return s.sent_bytes; });
  each("pointreel_live_dropped_frames_total", "counter",
       "Frames of which a viewer got nothing because it was too slow.",
       [](S s) { return s.drops.frames; });
  each("pointreel_live_dropped_layers_total", "counter",
       "Layers that a viewer did not get because it was too slow.",
       [](S s) { return s.drops.layers; });
  each("pointreel_live_hops", "gauge", "Servers between the publisher and this one.",
       [](S s) { return s.hops; });
  each("pointreel_live_lag_seconds", "gauge",
       "From the capture of the newest frame until its base was here, by both machines' clocks.",
       [](S s) { return static_cast<double>(s.lag_us) * 1e-6; });
  each("pointreel_live_lost_frames_total", "counter",
       "Frames that servers before this one could not send to it in time.",
       [](S s) { return s.lost.frames; });
  each("pointreel_live_lost_layers_total", "counter",
       "Layers that servers before this one could not send to it in time.",
       [](S s) { return s.lost.layers; });
  each("pointreel_live_newest_capture_seconds", "gauge",
       "Unix time at which the newest frame was captured.",
       [](S s) { return static_cast<double>(s.newest_capture_us) * 1e-6; });
}

}  // namespace

std::string write_metrics(const Metrics& metrics, const Gauges& gauges) {
  MetricsText page;
  page.begin("pointreel_http_responses_total", "counter", "Responses by status.");
  for (std::size_t i = 0; i < metrics.responses.size(); ++i) {
    const double count = number(metrics.responses[i]);
    if (count > 0) {
      page.value(count, fmt::format("status=\"{}\"", Metrics::kFirstStatus + static_cast<int>(i)));
    }
  }
  page.one("pointreel_http_body_bytes_total", "counter", "Bytes of bodies sent.",
           number(metrics.body_bytes));
  page.one("pointreel_http_limited_requests_total", "counter",
           "Requests answered with 429 because they came too fast.",
           number(metrics.limited_requests));
  page.one("pointreel_connections", "gauge", "Open connections.",
           static_cast<double>(gauges.open_connections));
  page.one("pointreel_connections_total", "counter", "Accepted connections.",
           number(metrics.connections));
  page.begin("pointreel_connections_refused_total", "counter",
             "Connections for which there was no room.");
  page.value(number(metrics.refused_full), "reason=\"full\"");
  page.value(number(metrics.refused_address), "reason=\"address\"");
  page.one("pointreel_connections_evicted_total", "counter",
           "Idle connections that were closed to make room.",
           static_cast<double>(gauges.evicted_connections));
  page.one("pointreel_tls_failed_handshakes_total", "counter",
           "Connections whose TLS handshake failed.", number(metrics.failed_handshakes));
  page.begin("pointreel_live_sessions_total", "counter", "Live sessions that began.");
  page.value(number(metrics.viewers), "kind=\"view\"");
  page.value(number(metrics.publishers), "kind=\"publish\"");
  page.begin("pointreel_live_refused_publishers_total", "counter", "Publishers that were refused.");
  constexpr std::array kReasons = {"hellos", "no-hello", "slow", "bytes", "message"};
  static_assert(kReasons.size() == static_cast<std::size_t>(Metrics::Refused::kCount));
  for (std::size_t i = 0; i < kReasons.size(); ++i) {
    page.value(number(metrics.refused_publishers[i]), fmt::format("reason=\"{}\"", kReasons[i]));
  }
  page.one("pointreel_live_waiting_hellos", "gauge", "Publishers that have not said hello.",
           static_cast<double>(gauges.waiting_hellos));
  page.one("pointreel_live_unfinished_bytes", "gauge",
           "Bytes of publishers' messages that are not complete.",
           static_cast<double>(gauges.unfinished_bytes));
  write_streams(page, gauges.streams);
  write_process(page);
  return std::move(page.text_);
}

}  // namespace pointreel
