#include "tests/load/load_generator.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>

#include "common/base/try.h"
#include "tests/load/crowd.h"
#include "tests/load/viewers.h"

namespace pointreel {
namespace {

double thread_cpu_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

LoadClock::duration seconds(double s) {
  return std::chrono::duration_cast<LoadClock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

Result<LoadFigures> run_load(const LoadOptions& options) {
  const Url url = TRY(parse_url(options.url));
  const bool live = url.scheme == "ws";
  if (!live && url.scheme != "http") {
    return fail(ErrorCode::argument, options.url + ": must begin with http:// or ws://");
  }

  LoadRecord record;
  std::shared_ptr<const PackageRequests> requests;
  if (!live) requests = TRY(package_requests(options, url));
  std::vector<std::unique_ptr<CrowdMember>> members;
  for (unsigned i = 0; i < options.viewers; ++i) {
    // Multiples of the golden ratio are spread evenly for any number of viewers.
    const double phase = std::fmod(0.6180339887498949 * i, 1.0);
    members.push_back(live ? live_viewer(url, options.token, record)
                           : package_viewer(requests, phase, record));
    TRY(members.back()->connect(url));
  }

  const auto now = LoadClock::now();
  const auto bytes = [&] {
    std::uint64_t sum = 0;
    for (const auto& member : members) sum += member->bytes();
    return sum;
  };
  std::uint64_t bytes_before = 0;
  double cpu_before = 0.0;
  const auto measured_from = now + seconds(options.warm_up);
  run_crowd(
      members, now, measured_from + seconds(options.seconds),
      [&] {
        record.on = true;
        bytes_before = bytes();
        cpu_before = thread_cpu_seconds();
      },
      measured_from);
  LoadFigures figures = std::move(record.figures);
  figures.seconds = options.seconds;
  figures.bytes = bytes() - bytes_before;
  figures.cpu_seconds = thread_cpu_seconds() - cpu_before;
  for (const auto& member : members) figures.broken += member->broken();
  std::sort(figures.delays_ms.begin(), figures.delays_ms.end());
  return figures;
}

}  // namespace pointreel
