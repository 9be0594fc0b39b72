// The inputs of a publisher.

#include "server/publish/frame_input.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "codec/files/unread_properties.h"
#include "codec/package/steady_grid.h"
#include "pointreel/draco.h"
#include "server/commands/commands.h"
#include "server/publish/publisher.h"
#include "tests/packed_clouds.h"

namespace pointreel::frame_input_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Time that passes when a test waits on it or advances it.
struct FakeTime {
  std::atomic<std::uint64_t> now_us = 5'000'000;

  LiveClock clock() {
    LiveClock clock;
    clock.now_us = [this] { return now_us.load(); };
    clock.wait_until = [this](std::uint64_t time_us, const std::stop_token&) {
      if (time_us > now_us) now_us = time_us;
    };
    return clock;
  }
};

class FrameInputTest : public PackTest {
 protected:
  /// Writes frames of 101, 102, ... points.
  CloudSequence write(std::size_t frames) {
    ::write_frames(frames_, frames, 101);
    return list_cloud_frames({frames_}).value();
  }
};

/// Returns the number of points of the next frame, or 0 at the end.
std::size_t next_points(FrameInput& input, const std::stop_token& stop = {}) {
  const auto frame = input.next(stop);
  if (!frame || !*frame) return 0;
  return (*frame)->cloud.value().cloud.size();
}

TEST_F(FrameInputTest, files_are_played_at_their_rate) {
  FakeTime time;
  const auto input = play_files(write(3), 10.0, false, time.clock());
  std::vector<std::uint64_t> captured;
  while (const auto frame = input->next({}).value()) captured.push_back(frame->capture_us);
  EXPECT_THAT(captured, testing::ElementsAre(5'000'000, 5'100'000, 5'200'000));
  EXPECT_EQ(input->skipped(), 0u);
}

TEST_F(FrameInputTest, a_loop_starts_over_after_the_last_file) {
  FakeTime time;
  const auto input = play_files(write(2), 10.0, true, time.clock());
  std::vector<std::size_t> points;
  for (int i = 0; i < 5; ++i) points.push_back(next_points(*input));
  EXPECT_THAT(points, testing::ElementsAre(101, 102, 101, 102, 101));
}

TEST_F(FrameInputTest, a_slow_reader_gets_the_newest_frame_and_never_misses_the_last) {
  FakeTime time;
  const auto input = play_files(write(12), 10.0, false, time.clock());
  std::size_t taken = 0, last = 0;
  std::uint64_t before = 0;
  while (const auto frame = input->next({}).value()) {
    EXPECT_GT(frame->capture_us, before);
    before = frame->capture_us;
    last = frame->cloud.value().cloud.size();
    ++taken;
    time.now_us += 250'000;
  }
  EXPECT_EQ(last, 112u);
  EXPECT_LT(taken, 12u);
  EXPECT_EQ(taken + input->skipped(), 12u);
}

TEST_F(FrameInputTest, a_file_that_cannot_be_read_fails_only_its_own_frame) {
  FakeTime time;
  write(2);
  std::ofstream(frames_ / "frame_0.ply") << "no cloud";
  const auto input = play_files(list_cloud_frames({frames_}).value(), 10.0, false, time.clock());
  const auto bad = input->next({}).value();
  ASSERT_TRUE(bad);
  EXPECT_FALSE(bad->cloud);
  EXPECT_THAT(bad->name, HasSubstr("frame_0.ply"));
  EXPECT_THAT(bad->cloud.error().message, testing::StartsWith(bad->name + ": "));
  EXPECT_EQ(next_points(*input), 102u);
}

TEST_F(FrameInputTest, stopping_ends_a_wait_for_the_next_file) {
  std::stop_source stop;
  const auto input = play_files(write(2), 0.001, true);
  EXPECT_EQ(next_points(*input, stop.get_token()), 101u);
  std::jthread stopper([&] { stop.request_stop(); });
  next_points(*input, stop.get_token());
  EXPECT_EQ(next_points(*input, stop.get_token()), 0u);
}

TEST_F(FrameInputTest, a_folder_is_followed_from_its_newest_file_on) {
  write(3);
  const auto input = follow_folder(frames_).value();
  EXPECT_EQ(next_points(*input), 103u);
  ASSERT_TRUE(write_ply(frames_ / "frame_3.tmp", ellipsoid(50)));
  fs::rename(frames_ / "frame_3.tmp", frames_ / "frame_3.ply");
  EXPECT_EQ(next_points(*input), 50u);
  ASSERT_TRUE(write_ply(frames_ / "frame_4.ply", ellipsoid(60)));
  ASSERT_TRUE(write_ply(frames_ / "frame_5.ply", ellipsoid(70)));
  std::ofstream(frames_ / "notes.txt") << "not a frame";
  EXPECT_EQ(next_points(*input), 70u) << "the newest of the frames that arrived meanwhile";
  EXPECT_EQ(input->skipped(), 1u);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(next_points(*input, stop.get_token()), 0u);
}

TEST_F(FrameInputTest, files_with_capital_extensions_and_links_are_followed_too) {
  const fs::path folder = frames_ / "followed", file = write(1).frames.front().file;
  fs::create_directory(folder);
  const auto input = follow_folder(folder).value();
  const auto next = [&] {
    const auto frame = input->next({});
    return frame && *frame ? fs::path((*frame)->name).filename().string() : std::string("nothing");
  };
  fs::copy_file(file, folder / "U.PLY");
  EXPECT_EQ(next(), "U.PLY");
  fs::create_symlink(file, folder / "symbolic.ply");
  EXPECT_EQ(next(), "symbolic.ply");
  fs::create_hard_link(file, folder / "hard.Ply");
  EXPECT_EQ(next(), "hard.Ply");
  EXPECT_EQ(input->skipped(), 0u);
}

TEST_F(FrameInputTest, the_newest_file_is_found_when_more_came_than_the_system_keeps_events_of) {
  const fs::path folder = frames_ / "followed";
  fs::create_directory(folder);
  const auto input = follow_folder(folder).value();
  std::ifstream limit("/proc/sys/fs/inotify/max_queued_events");
  std::size_t events = 0;
  ASSERT_TRUE(limit >> events);
  if (events > 50'000) GTEST_SKIP() << "that would take too long";
  // Two events each.
  for (std::size_t i = 0; i < events / 2 + 10; ++i)
    std::ofstream(folder / fmt::format("{}.ply", i)) << "ply";
  ASSERT_TRUE(write_ply(folder / "last.ply", ellipsoid(60)));
  EXPECT_EQ(next_points(*input), 60u);
  EXPECT_EQ(input->skipped(), events / 2 + 10);
}

TEST_F(FrameInputTest, a_pipe_in_a_followed_folder_is_not_waited_for) {
  const fs::path folder = frames_ / "followed";
  fs::create_directory(folder);
  const auto input = follow_folder(folder).value();
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::rename(folder / "pipe", folder / "frame.ply");
  const auto frame = input->next({}).value();
  ASSERT_TRUE(frame);
  ASSERT_FALSE(frame->cloud);
  EXPECT_EQ(frame->cloud.error().message, frame->name + ": is not a regular file");
}

TEST_F(FrameInputTest, a_followed_folder_that_goes_away_is_an_error) {
  for (const bool removed : {true, false}) {
    const fs::path folder = frames_ / "followed";
    fs::create_directory(folder);
    const auto input = follow_folder(folder).value();
    if (removed) {
      fs::remove(folder);
    } else {
      fs::rename(folder, frames_ / "elsewhere");
    }
    fs::create_directories(folder);
    const auto frame = input->next({});
    ASSERT_FALSE(frame);
    EXPECT_THAT(frame.error().message, testing::HasSubstr("was removed or renamed"));
  }
}

TEST_F(FrameInputTest, a_folder_that_does_not_exist_cannot_be_followed) {
  const auto input = follow_folder(frames_ / "nowhere");
  ASSERT_FALSE(input);
  EXPECT_THAT(input.error().message, HasSubstr("nowhere"));
}

/// Both ends of a pipe.
struct Pipe {
  Pipe() { EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0); }
  ~Pipe() {
    ::close(ends[0]);
    finish();
  }
  void put(ByteView bytes) {
    EXPECT_EQ(::write(ends[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void put_size(std::uint32_t size) {
    Bytes head(4);
    std::memcpy(head.data(), &size, 4);
    put(head);
  }
  void put_frame(const PointCloud& cloud) {
    const Bytes file = ply_bytes(cloud);
    put_size(static_cast<std::uint32_t>(file.size()));
    put(file);
  }
  void finish() {
    if (ends[1] >= 0) ::close(ends[1]);
    ends[1] = -1;
  }
  int ends[2] = {-1, -1};
};

TEST(PipeInput, gives_frames_as_they_arrive_and_ends_with_the_pipe) {
  Pipe pipe;
  FakeTime time;
  const auto input = read_pipe(pipe.ends[0], time.clock());
  pipe.put_frame(ellipsoid(30));
  EXPECT_EQ(next_points(*input), 30u);
  time.now_us = 7'000'000;
  pipe.put_frame(ellipsoid(40));
  const auto frame = input->next({}).value();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->capture_us, 7'000'000u);
  pipe.finish();
  const auto end = input->next({});
  ASSERT_TRUE(end);
  EXPECT_FALSE(*end);
}

TEST(PipeInput, bytes_that_are_not_a_cloud_fail_only_their_own_frame) {
  Pipe pipe;
  const auto input = read_pipe(pipe.ends[0]);
  pipe.put_size(3);
  pipe.put(Bytes{1, 2, 3});
  const auto bad = input->next({}).value();
  ASSERT_TRUE(bad);
  EXPECT_FALSE(bad->cloud);
  pipe.put_frame(ellipsoid(30));
  EXPECT_EQ(next_points(*input), 30u);
}

std::string pipe_error(const std::function<void(Pipe&)>& write) {
  Pipe pipe;
  const auto input = read_pipe(pipe.ends[0]);
  write(pipe);
  pipe.finish();
  const auto frame = input->next({});
  return frame ? "none" : frame.error().message;
}

TEST(PipeInput, ends_with_an_error_at_an_invalid_size_or_a_truncated_frame) {
  EXPECT_THAT(pipe_error([](Pipe& pipe) { pipe.put_size(0x0a796c70); }), HasSubstr("is PLY"));
  EXPECT_THAT(pipe_error([](Pipe& pipe) { pipe.put_size(0xffffffff); }), HasSubstr("at most"));
  EXPECT_THAT(pipe_error([](Pipe& pipe) { pipe.put(Bytes{1, 0}); }), HasSubstr("within the size"));
  EXPECT_THAT(pipe_error([](Pipe& pipe) {
                pipe.put_size(100);
                pipe.put(Bytes(99));
              }),
              HasSubstr("within frame 0"));
}

TEST(PipeInput, stopping_ends_a_wait_for_the_next_frame) {
  Pipe pipe;
  const auto input = read_pipe(pipe.ends[0]);
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  const auto frame = input->next(stop.get_token());
  ASSERT_TRUE(frame);
  EXPECT_FALSE(*frame);
}

TEST(SteadyGrid, stays_the_same_until_a_frame_does_not_fit) {
  SteadyGrid steady{PublishOptions{}};
  const Box box{{0, 0, 0}, {1, 2, 1}};
  const Cube first = steady.of({}, box).value().cube;
  EXPECT_EQ(steady.of({}, {{-0.05, 0.1, 0}, {1.05, 2.1, 0.5}}).value().cube, first);
  EXPECT_EQ(steady.of({}, Box{}).value().cube, first);
  const Cube second = steady.of({}, {{2, 0, 0}, {3, 2, 1}}).value().cube;
  EXPECT_FALSE(second == first);
  EXPECT_EQ(steady.of({}, box).value().cube, second) << "it held the new box before";
  const Cube far = steady.of({}, {{30, 0, 0}, {31, 2, 1}}).value().cube;
  EXPECT_LE(far.edge, 2.5) << "the cube does not reach back to the old place";
}

TEST(SteadyGrid, recovers_from_a_frame_with_a_point_far_away) {
  SteadyGrid steady{PublishOptions{}};
  const Box box{{0, 0, 0}, {1, 2, 1}};
  EXPECT_LE(steady.of({}, box).value().cube.edge, 2.5);
  EXPECT_GE(steady.of({}, {{0, 0, 0}, {1e12, 2, 1}}).value().cube.edge, 1e12);
  EXPECT_LE(steady.of({}, box).value().cube.edge, 2.5);
  (void)steady.of({}, {{0, 0, 0}, {1e38, 1e38, 1e38}});
  EXPECT_LE(steady.of({}, box).value().cube.edge, 2.5);
  const Cube before = steady.of({}, box).value().cube;
  EXPECT_EQ(steady.of({}, {{0.4, 0.9, 0.4}, {0.7, 1.2, 0.6}}).value().cube, before)
      << "somebody who crouches keeps the cube";
}

TEST(SteadyGrid, keeps_the_requested_voxel_size) {
  PublishOptions options;
  options.voxel = 0.01;
  SteadyGrid steady(options);
  const Grid grid = steady.of({}, {{0, 0, 0}, {1, 2, 1}}).value();
  const auto& octree = std::get<OctreeOptions>(grid.encode.codec);
  EXPECT_NEAR(grid.cube.edge / std::exp2(octree.depth.depth), 0.01, 1e-9);
}

PointCloud voxelised(double step, int first, int last);

TEST(SteadyGrid, centres_the_requested_voxels_on_those_that_they_merge) {
  PublishOptions options;
  for (const double voxel : {2.0, 3.0, 4.0}) {
    options.voxel = voxel;
    SteadyGrid steady(options);
    for (const int moved : {0, 1, 7}) {
      const PointCloud cloud = voxelised(1.0, 5 + moved, 40 + moved);
      const Cube cube = steady.of(cloud, bounds(cloud)).value().cube;
      // The smallest source coordinate of the first voxel lies half a step above its corner.
      const double above = cube.origin.x + 0.5;
      EXPECT_EQ(above, std::round(above)) << voxel << ", " << moved;
    }
  }
}

/// Points at these multiples of the step.
PointCloud voxelised(double step, int first, int last) {
  PointCloud cloud;
  for (int x = first; x <= last; ++x) {
    for (int y = first; y <= last; ++y)
      cloud.positions.emplace_back(static_cast<float>(x * step), static_cast<float>(y * step), 0);
  }
  return cloud;
}

TEST(SteadyGrid, gives_voxelised_frames_back_exactly) {
  for (const double step : {1.0, 0.01}) {
    SteadyGrid steady{PublishOptions{}};
    std::optional<Cube> first;
    for (const int moved : {0, 1, 2, 40}) {
      const PointCloud cloud = voxelised(step, 5 + moved, 40 + moved);
      const Grid grid = steady.of(cloud, bounds(cloud)).value();
      if (!first) first = grid.cube;
      EXPECT_TRUE(moved > 2 || grid.cube == *first) << "voxels must not jump";
      const EncodedFrame encoded = encode_frame(cloud, grid.cube, grid.encode).value();
      const PointCloud back = decode_frame(layer_views(encoded.layers), {}).value().cloud;
      ASSERT_EQ(back.size(), cloud.size()) << step << ", " << moved;
      std::set<std::pair<long, long>> places;
      for (const glm::vec3& p : back.positions) {
        const glm::dvec3 at = (back.origin + glm::dvec3(p)) / step;
        EXPECT_LT(glm::length(at - glm::round(at)), 1e-3) << step << ", " << moved;
        places.insert({std::lround(at.x), std::lround(at.y)});
      }
      EXPECT_EQ(places.size(), cloud.size());
    }
  }
}

TEST(SteadyGrid, has_the_cells_of_cleaned_points_until_they_change) {
  SteadyGrid steady{PublishOptions{}};
  const PointCloud cloud = voxelised(0.3, 0, 5);
  const auto cell = [&](double best) {
    CleanReport cleaning;
    cleaning.cleaned = true;
    cleaning.cell = best;
    const Grid grid = steady.of(cloud, bounds(cloud), cleaning).value();
    return std::ldexp(grid.cube.edge, -std::get<OctreeOptions>(grid.encode.codec).depth.most);
  };
  const double first = cell(0.01);
  EXPECT_NEAR(first, 0.01, 0.001);
  EXPECT_EQ(cell(0.011), first);
  EXPECT_EQ(cell(0.009), first);
  EXPECT_NEAR(cell(0.015), 0.015, 0.0015);
}

TEST(SteadyGrid, leaves_a_lattice_for_a_frame_that_is_not_on_it) {
  SteadyGrid steady{PublishOptions{}};
  const PointCloud on = voxelised(1.0, 0, 20);
  PointCloud off = on;
  for (glm::vec3& p : off.positions) p += 0.1f * glm::sin(7.0f * p);
  const Box box{{-1, -1, 0}, {21, 21, 0}};
  const auto most = [](const Grid& grid) {
    return std::get<OctreeOptions>(grid.encode.codec).depth.most;
  };
  EXPECT_LT(most(steady.of(on, box).value()), 10);
  EXPECT_EQ(most(steady.of(off, box).value()), kMaxDepth);
  EXPECT_LT(most(steady.of(on, box).value()), 10);
}

TEST(UnreadProperties, are_named_once) {
  UnreadProperties unread;
  EXPECT_EQ(unread.fresh(std::vector<std::string>{"a", "b"}), "a, b");
  EXPECT_EQ(unread.fresh(std::vector<std::string>{"b", "c"}), "c");
  EXPECT_EQ(unread.fresh(std::vector<std::string>{"a", "c"}), "");
  std::set<std::string> many;
  for (int i = 10; i < 30; ++i) many.insert("p" + std::to_string(i));
  EXPECT_THAT(unread.fresh(many), HasSubstr("p17 and 12 more"));
}

/// The usage error that `publish` prints for a command line it refuses.
std::string usage_error(const std::vector<std::string>& arguments) {
  cli::Program app;
  int code = -1;
  add_publish_command(app, code);
  testing::internal::CaptureStderr();
  std::vector<std::string> all = {"publish"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const auto parsed = app.parse(all);
  if (!parsed) code = 2;
  const std::string refusal =
      (parsed ? "" : parsed.error().message) + testing::internal::GetCapturedStderr();
  return code == 2 ? refusal : "accepted with " + std::to_string(code);
}

TEST(PublishCommand, refuses_contradictory_options_before_it_connects) {
  const std::string to = "ws://127.0.0.1:1/live/me";
  EXPECT_THAT(usage_error({"-i", "-", "--to", "http://host/live/me"}), HasSubstr("ws://"));
  EXPECT_THAT(usage_error({"-i", "-", "--to", "ws://host/live/"}), HasSubstr("stream's name"));
  EXPECT_THAT(usage_error({"-i", "-", "--to", to + "?publish"}), HasSubstr("stream's name"));
  EXPECT_THAT(usage_error({"-i", "-", "--to", to, "--loop"}), HasSubstr("--loop"));
  EXPECT_THAT(usage_error({"-i", ".", "--to", to, "--loop", "--follow"}), HasSubstr("exclude"));
  EXPECT_THAT(usage_error({"-i", ".", "--to", to, "--fps", "0"}), HasSubstr("--fps"));
  EXPECT_THAT(usage_error({"-i", ".", "--to", to, "--frame-time", "0"}), HasSubstr("--frame-time"));
  EXPECT_THAT(usage_error({"-i", ".", "--to", to, "--qp", "9"}), HasSubstr("--codec"));
  EXPECT_THAT(usage_error({"-i", "."}), HasSubstr("--to"));
}

}  // namespace
}  // namespace pointreel::frame_input_test
