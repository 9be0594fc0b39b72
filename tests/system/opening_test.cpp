#include "client/playback/opening.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "tests/packed_reel.h"
#include "tests/scripted_http_server.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::opening_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

Camera looking(const Box& bounds, Up up) {
  Camera camera;
  camera.up = up;
  camera.frame_bounds(bounds, 1.0);
  return camera;
}

void nobody(std::size_t, std::uint32_t, const Error&) {}

class OpeningTest : public testing::Test {
 protected:
  std::string ply(const std::string& name) {
    const auto path = folder_.path() / name;
    EXPECT_TRUE(write_ply(path, ball(200, 1)));
    return path.string();
  }
  /// Waits for the stage. Returns null and sets `error_` if opening fails.
  std::unique_ptr<Stage> wait(Opening& opening) {
    std::optional<Opening::Opened> opened;
    EXPECT_TRUE(wait_until([&] { return (opened = opening.poll()).has_value(); }));
    if (!opened) return nullptr;
    EXPECT_FALSE(opening.poll()) << "it is given only once";
    if (*opened) return std::move(**opened);
    error_ = opened->error().message;
    return nullptr;
  }

  TemporaryFolder folder_;
  std::string error_;
};

TEST_F(OpeningTest, gives_the_stage_once_it_is_ready) {
  const std::string file = ply("one.ply");
  Opening opening({{file}}, {}, looking, nobody);
  const auto stage = wait(opening);
  ASSERT_TRUE(stage) << error_;
  EXPECT_EQ(stage->size(), 1u);
  EXPECT_FALSE(stage->bounds().empty());
  EXPECT_TRUE(wait_until([&] {
    stage->update(std::chrono::steady_clock::now());
    return stage->scene()[0].frame != nullptr;
  }));
}

TEST_F(OpeningTest, says_when_a_stage_is_open_and_a_frame_is_ready) {
  std::atomic<int> said{0};
  Stage::Options options;
  options.on_ready = [&] { ++said; };
  Opening opening({{ply("frame.ply")}}, options, looking, nobody);
  ASSERT_TRUE(wait_until([&] { return said > 0; }));
  const auto stage = wait(opening);
  ASSERT_TRUE(stage) << error_;
  // Whoever looks only when told to sees the frame.
  int seen = 0;
  EXPECT_TRUE(wait_until([&] {
    if (const int before = said; before == std::exchange(seen, before)) return false;
    return stage->update(std::chrono::steady_clock::now()).changes.size() == 1;
  }));
  stage->silence();
  const int silenced = said;
  stage->reel(0)->seek(0, std::chrono::steady_clock::now());
  EXPECT_FALSE(wait_until([&] { return said != silenced; }, kMoment));
}

TEST_F(OpeningTest, gives_the_error_if_there_is_nothing_to_open) {
  Opening opening({{(folder_.path() / "nothing").string()}}, {}, looking, nobody);
  EXPECT_FALSE(wait(opening));
  EXPECT_THAT(error_, HasSubstr("nothing: no such file or folder"));
}

TEST_F(OpeningTest, refuses_to_begin_beyond_the_end_of_every_reel) {
  Stage::Options options;
  options.reel.start_us = 40'000;
  Opening opening({{ply("frame.ply")}}, options, looking, nobody);
  EXPECT_FALSE(wait(opening));
  EXPECT_THAT(error_, HasSubstr("frame.ply: ends at 0.033333 s, before 0.04 s"));
  options.reel.start_us = 33'333;  // the end itself shows the last frame
  Opening again({{ply("frame.ply")}}, options, looking, nobody);
  EXPECT_TRUE(wait(again)) << error_;
}

TEST_F(OpeningTest, can_be_abandoned_while_a_host_does_not_answer) {
  std::atomic<int> asked{0};
  std::atomic<bool> over{false};
  ScriptedHttpServer server([&](int, const std::string&) {
    ++asked;
    wait_until([&] { return over.load(); });
    return false;
  });
  Stage::Options options;
  options.source.stall_timeout = std::chrono::minutes(10);
  std::atomic<bool> gone{false};
  {
    Opening opening(
        {{server.url() + "/reel"}}, options,
        [&](const Box&, Up) {
          EXPECT_FALSE(gone);
          return Camera{};
        },
        nobody);
    EXPECT_TRUE(wait_until([&] { return asked == 1; }));
    EXPECT_FALSE(opening.poll());
  }
  gone = true;
  over = true;
}

TEST_F(OpeningTest, reports_what_it_waits_for_once_that_takes_too_long) {
  std::atomic<bool> over{false};
  ScriptedHttpServer server([&](int, const std::string&) {
    wait_until([&] { return over.load(); });
    return false;
  });
  Stage::Options options;
  options.source.stall_timeout = milliseconds(50);
  options.source.open_attempts = 1'000'000;
  {
    Opening opening({{server.url() + "/reel"}}, options, looking, nobody);
    ASSERT_TRUE(wait_until([&] { return opening.trouble().has_value(); }));
    EXPECT_THAT(*opening.trouble(), HasSubstr("no answer within 0.05 s; trying again"));
    EXPECT_THAT(*opening.trouble(), testing::StartsWith("127.0.0.1:"));
    EXPECT_FALSE(opening.poll());
  }
  over = true;
}

TEST_F(OpeningTest, calls_nothing_after_its_destruction) {
  // A hundred openings are each cancelled a little later than the one before, so that some are
  // caught in the middle of every call.
  for (int i = 0; i < 100; ++i) {
    auto alive = std::make_unique<std::atomic<bool>>(true);
    const auto* watched = alive.get();
    {
      Opening opening(
          {{ply("frame.ply")}}, {},
          [watched](const Box& bounds, Up up) {
            EXPECT_TRUE(*watched);
            return looking(bounds, up);
          },
          [watched](std::size_t, std::uint32_t, const Error&) { EXPECT_TRUE(*watched); });
      std::this_thread::sleep_for(std::chrono::microseconds(20 * i));
    }
    *alive = false;
  }
}

TEST_F(OpeningTest, retires_stages_together_with_their_error_handlers) {
  const std::string file = ply("frame2.ply");
  std::ofstream(folder_.path() / "frame10.ply") << "ply\nbroken\n";
  std::atomic<int> errors{0};
  std::atomic<bool> retired{false};
  Opening opening({{folder_.path().string()}}, {}, looking,
                  [&](std::size_t, std::uint32_t frame, const Error&) {
                    EXPECT_EQ(frame, 1u);
                    EXPECT_FALSE(retired);
                    ++errors;
                  });
  auto stage = wait(opening);
  ASSERT_TRUE(stage) << error_;
  EXPECT_TRUE(wait_until([&] { return errors > 0; }));
  retire(std::move(stage));
  retired = true;
  retire(nullptr);
}

TEST_F(OpeningTest, plays_files_dropped_together_as_one_reel) {
  const std::string second = ply("b2.ply"), tenth = ply("b10.ply"), first = ply("b1.PLY");
  const auto sources = sources_of({tenth, "http://host/reel", first, second});
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[1].where, "http://host/reel");
  EXPECT_THAT(sources[0].where, HasSubstr("and 2 more"));
  Opening opening({sources[0]}, {}, looking, nobody);
  const auto stage = wait(opening);
  ASSERT_TRUE(stage) << error_;
  EXPECT_EQ(stage->reel(0)->timeline().frame_count(), 3u);
  EXPECT_EQ(stage->reel(0)->name(), "b1.PLY to b10.ply");
}

TEST_F(OpeningTest, opens_a_single_file_or_folder_as_it_is) {
  const std::string file = ply("one.ply");
  const auto sources = sources_of({file});
  ASSERT_EQ(sources.size(), 1u);
  EXPECT_EQ(sources[0].where, file);
  EXPECT_TRUE(sources[0].files.empty());
  EXPECT_EQ(sources_of({"folder", "other"}).size(), 2u);
  EXPECT_TRUE(sources_of({}).empty());
}

TEST_F(OpeningTest, what_opened_cannot_be_taken_before_that_was_told) {
  // The thread that opens could otherwise tell it when nobody is there any more.
  for (int i = 0; i < 500; ++i) {
    std::atomic<bool> told = false;
    Stage::Options options;
    options.on_ready = [&told] { told = true; };
    Opening opening({{(folder_.path() / "nothing").string()}}, options, looking, nobody);
    while (!opening.poll()) {
    }
    ASSERT_TRUE(told) << "round " << i;
  }
}

TEST_F(OpeningTest, a_finished_thread_has_cleaned_up_too) {
  // As libraries do with memory of theirs for each thread. At the end of the program, they would
  // meet their own destruction.
  static std::atomic<bool> cleaned_up = false;
  struct Slow {
    ~Slow() {
      std::this_thread::sleep_for(milliseconds(100));
      cleaned_up = true;
    }
  };
  {
    Stage::Options options;
    options.on_ready = [] { thread_local const Slow slow; };
    Opening opening({{(folder_.path() / "nothing").string()}}, options, looking, nobody);
    EXPECT_FALSE(wait(opening));
  }
  EXPECT_TRUE(wait_until([] { return !unfinished(); }));
  EXPECT_TRUE(cleaned_up);
}

}  // namespace
}  // namespace pointreel::opening_test
