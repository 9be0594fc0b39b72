// Reads frames of a reel by C++ and by the C interface, for tests/bench/bindings/measure. For each
// line of standard input, it reads the frame of that number and prints how many milliseconds it
// took, and how many of all processors: by C++; by C; by C with a copy into the caller's arrays.
#include <chrono>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "client/bindings/c/pointreel.h"
#include "client/source/decode_fetched.h"
#include "client/source/open_source.h"
#include "common/process/print.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

constexpr const char* kName = "pointreel_bindings_bench";

/// "MILLISECONDS OF_ALL_PROCESSORS", with `good` false if the work fails.
template <class Work>
std::string time_of(bool& good, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processors = std::clock();
  good = work() && good;
  const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
  return fmt::format("{} {}", passed.count(),
                     1e3 * static_cast<double>(std::clock() - processors) / CLOCKS_PER_SEC);
}

bool read_by_cpp(Source& source, std::uint32_t frame) {
  FetchRequest request;
  request.frame = frame;
  const auto fetched = source.fetch(request);
  if (!fetched) return false;
  DecodeLimits limits;
  limits.executor = tbb_executor();
  const auto decoded = decode_fetched(*fetched, limits);
  return decoded && !decoded->cloud.empty();
}

struct Room {
  std::vector<float> positions, normals;
  std::vector<std::uint16_t> colors;
};

bool read_by_c(pointreel_reel* reel, std::uint32_t number, Room* room) {
  pointreel_frame* frame = nullptr;
  if (pointreel_reel_read(reel, number, nullptr, &frame) != POINTREEL_OK) return false;
  bool good = true;
  if (room != nullptr) {
    std::size_t count = 0;
    good = pointreel_frame_get_positions(frame, nullptr, 0, &count) == POINTREEL_OK;
    room->positions.resize(3 * count);
    room->colors.resize(3 * count);
    good = good && pointreel_frame_get_positions(frame, room->positions.data(), count, nullptr) ==
                       POINTREEL_OK;
    if (pointreel_frame_colors(frame) != nullptr)
      good = good && pointreel_frame_get_colors_16(frame, room->colors.data(), count, nullptr) ==
                         POINTREEL_OK;
  }
  pointreel_frame_close(frame);
  return good;
}

int run(const char* where) {
  const auto source = open_source(where);
  pointreel_reel* reel = nullptr;
  if (!source || pointreel_reel_open(where, nullptr, &reel) != POINTREEL_OK) {
    print_error(kName, source ? pointreel_error_message() : source.error().message);
    return 1;
  }
  Room room;
  bool good = true;
  for (std::uint32_t frame = 0; good && std::cin >> frame;) {
    good &= read_by_cpp(**source, frame);  // wakes the threads
    const std::string cpp = time_of(good, [&] { return read_by_cpp(**source, frame); });
    const std::string c = time_of(good, [&] { return read_by_c(reel, frame, nullptr); });
    const std::string copied = time_of(good, [&] { return read_by_c(reel, frame, &room); });
    if (!print_lines(fmt::format("{} {} {}\n", cpp, c, copied))) return 1;
  }
  pointreel_reel_close(reel);
  if (!good) print_error(kName, "a frame could not be read");
  return good ? 0 : 1;
}

}  // namespace
}  // namespace pointreel

int main(int argc, char** argv) {
  if (argc == 2) return pointreel::run(argv[1]);
  pointreel::print_error("pointreel_bindings_bench",
                         "give a reel; see tests/bench/bindings/measure");
  return 2;
}
