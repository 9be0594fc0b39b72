// Live streams with the real programs: published from a folder, relayed, viewed and recorded, while
// a server is killed in between.

#include "codec/live/live.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "codec/files/ply.h"
#include "codec/package/manifest.h"
#include "common/net/websocket.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"
#include "tests/e2e/process.h"
#include "tests/e2e/server_address.h"
#include "tests/read_file.h"
#include "tests/temporary_folder.h"
#include "tests/wait.h"

namespace pointreel::e2e::live_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kFrames = 3;
constexpr int kDepth = 8;
constexpr auto kLong = 60s;

/// A spiral that turns from frame to frame. Each frame has its own number of points.
PointCloud spiral(int frame) {
  PointCloud cloud;
  for (int i = 0; i < 3000 + frame; ++i) {
    const float turn = 0.01f * static_cast<float>(i) + static_cast<float>(frame);
    cloud.positions.emplace_back(std::cos(turn), 0.001f * static_cast<float>(i), std::sin(turn));
    cloud.colors.emplace_back(257 * (i % 256), 257 * frame, 0);
  }
  return cloud;
}

EncodeOptions encode_options() {
  OctreeOptions octree;
  octree.entropy = Entropy::zstd;
  octree.depth = DepthRule::fixed(kDepth);
  octree.color_quality = kLosslessColorQuality;
  EncodeOptions options;
  options.codec = octree;
  return options;
}

std::unique_ptr<Background> serve(const fs::path& record, const std::string& listen) {
  return std::make_unique<Background>(
      "pointreel-server",
      std::vector<std::string>{"serve", "--live", "--record", record.string(), "--listen", listen});
}

/// Connects again and again until the stream exists.
std::unique_ptr<WebSocket> join(const std::string& address) {
  std::unique_ptr<WebSocket> joined;
  wait_until([&] {
    auto socket = WebSocket::connect("ws://" + address + "/live/stage");
    if (socket) joined = *std::move(socket);
    return joined != nullptr;
  });
  return joined;
}

/// The messages that a viewer has received.
struct View {
  LiveHello hello;
  std::uint32_t frame = 0;
  std::vector<Chunks<Bytes>> layers;  ///< of a complete frame
};

/// Waits for a complete frame.
bool see(WebSocket& socket, View& view) {
  for (const auto end = Clock::now() + kLong; Clock::now() < end;) {
    const auto message = socket.receive(1s);
    if (!message) return false;
    if (!*message) continue;
    const Bytes& bytes = (*message)->bytes;
    if ((*message)->kind == WebSocket::Kind::text) {
      const auto text =
          parse_live_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      if (text && std::holds_alternative<LiveHello>(*text)) {
        view.hello = std::get<LiveHello>(*text);
      }
      continue;
    }
    const auto layer = parse_live_layer(bytes);
    if (!layer) return false;
    if (layer->layer == 0) view.layers.clear();
    if (layer->layer != view.layers.size()) continue;
    view.frame = layer->frame;
    const auto part = [&](std::size_t at, std::size_t size) {
      const ByteView chunk = layer->bytes.subspan(at, size);
      return Bytes(chunk.begin(), chunk.end());
    };
    const Chunks<std::uint32_t>& sizes = layer->sizes;
    view.layers.push_back({part(0, sizes.geometry), part(sizes.geometry, sizes.colors),
                           part(std::size_t{sizes.geometry} + sizes.colors, sizes.normals)});
    if (view.layers.size() == layer->layers) return true;
  }
  return false;
}

/// The number of the source frame that this equals exactly, or -1 if there is none.
int which(const View& view) {
  const auto decoded = decode_frame(layer_views(view.layers));
  if (!decoded) return -1;
  for (int i = 0; i < kFrames; ++i) {
    const auto encoded = encode_frame(spiral(i), decoded->cube, encode_options());
    const auto truth = decode_frame(layer_views(encoded.value().layers));
    if (truth->cloud.positions == decoded->cloud.positions &&
        truth->cloud.colors == decoded->cloud.colors) {
      return i;
    }
  }
  return -1;
}

TEST(Live, published_frames_are_viewed_and_recorded_exactly_across_a_killed_server) {
  const TemporaryFolder folder;
  const fs::path frames = folder.path() / "frames", record = folder.path() / "record";
  fs::create_directories(frames);
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(write_ply(frames / fmt::format("frame{}.ply", i), spiral(i)));
  }
  auto server = serve(record, "127.0.0.1:0");
  const std::string address = server_address(*server);
  ASSERT_FALSE(address.empty());
  Background publisher(
      "pointreel-server",
      {"publish", "-i", frames.string(), "--loop", "--fps", "20", "--depth", std::to_string(kDepth),
       "--quality", "100", "--frame-time", "100000", "--to", "ws://" + address + "/live/stage"});

  View view;
  {
    const auto viewer = join(address);
    ASSERT_NE(viewer, nullptr);
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(see(*viewer, view));
      EXPECT_GE(which(view), 0) << "frame " << view.frame;
    }
    EXPECT_EQ(view.hello.name, "stage");
    EXPECT_TRUE(view.hello.colors);
    EXPECT_FALSE(view.hello.normals);
  }
  const std::uint64_t session = view.hello.session;
  const std::uint32_t seen = view.frame;

  // The recording has at least a second. Then the server is killed without a chance to clean up.
  const fs::path recording = record / "stage";
  ASSERT_TRUE(wait_until([&] { return fs::exists(recording / kManifestName); }));
  server->end(SIGKILL);
  const Outcome verified = run("pointreel-server", {"verify", recording.string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  const auto manifest = read_manifest(recording);
  ASSERT_TRUE(manifest) << manifest.error().message;
  EXPECT_TRUE(manifest->live) << "the recording was still growing";
  EXPECT_GE(manifest->frame_count(), 5u);

  // The publisher finds the server again and continues.
  server = serve(record, address);
  ASSERT_FALSE(server_address(*server).empty());
  const auto viewer = join(address);
  ASSERT_NE(viewer, nullptr);
  ASSERT_TRUE(see(*viewer, view));
  EXPECT_EQ(view.hello.session, session);
  EXPECT_GT(view.frame, seen);
  EXPECT_GE(which(view), 0);

  // Ended properly, the second recording is an ordinary reel.
  EXPECT_EQ(publisher.end(SIGINT), 0);
  EXPECT_EQ(server->end(SIGTERM), 0);
  const auto second = read_manifest(record / "stage-2");
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_FALSE(second->live);
  const Outcome last = run("pointreel-server", {"verify", (record / "stage-2").string()});
  EXPECT_EQ(last.exit_code, 0) << last.out << last.err;
}

/// Limits the size of files that another process writes.
bool limit_files(pid_t pid, rlim_t bytes) {
  rlimit limit{};
  if (::prlimit(pid, RLIMIT_FSIZE, nullptr, &limit) != 0) return false;
  limit.rlim_cur = bytes;
  return ::prlimit(pid, RLIMIT_FSIZE, &limit, nullptr) == 0;
}

TEST(Live, a_recording_stops_while_it_cannot_be_written_and_then_continues) {
  const TemporaryFolder folder;
  const fs::path frames = folder / "frames", said = folder / "said";
  fs::create_directories(frames);
  ASSERT_TRUE(write_ply(frames / "frame.ply", spiral(0)));
  Surroundings surroundings;
  surroundings.err = said.string();
  Background server(
      "pointreel-server",
      {"serve", "--live", "--record", (folder / "record").string(), "--listen", "127.0.0.1:0"},
      surroundings);
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  Background publisher("pointreel-server", {"publish", "-i", frames.string(), "--loop", "--fps",
                                            "20", "--to", "ws://" + address + "/live/stage"});
  const fs::path recording = folder / "record" / "stage";
  ASSERT_TRUE(wait_until([&] { return fs::exists(recording / kManifestName); }));
  ASSERT_TRUE(limit_files(server.pid(), 1'000));  // less than a segment, more than a line
  ASSERT_TRUE(wait_until([&] { return read_file(said).find("has stopped") != std::string::npos; }));
  ASSERT_TRUE(limit_files(server.pid(), RLIM_INFINITY));
  ASSERT_TRUE(wait_until([&] { return read_file(said).find("continues") != std::string::npos; }));
  EXPECT_EQ(publisher.end(SIGINT), 0);
  EXPECT_EQ(server.end(SIGTERM), 0);
  const Outcome verified = run("pointreel-server", {"verify", recording.string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_FALSE(fs::exists(folder / "record" / "stage-2"));
}

TEST(Live, a_player_without_a_duration_says_what_ends_it_and_then_writes_its_picture) {
  const TemporaryFolder folder;
  const fs::path said = folder / "said", picture = folder / "picture.png";
  fs::create_directories(folder / "frames");
  ASSERT_TRUE(write_ply(folder / "frames/frame.ply", spiral(0)));
  Background server("pointreel-server", {"serve", "--live", "--listen", "127.0.0.1:0"});
  const std::string url = "ws://" + server_address(server) + "/live/stage";
  Background publisher("pointreel-server",
                       {"publish", "-i", (folder / "frames").string(), "--loop", "--to", url});
  Surroundings surroundings;
  surroundings.err = said.string();
  Background player("pointreel",
                    {"play", url, "--offscreen", "64x64", "--screenshot", picture.string()},
                    surroundings);
  ASSERT_TRUE(wait_until([&] { return read_file(said).find("--duration") != std::string::npos; }));
  EXPECT_EQ(player.end(SIGINT), 0);
  EXPECT_TRUE(fs::exists(picture));
}

TEST(Live, publishers_and_viewers_give_up_where_their_own_certificate_file_is_wrong) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_ply(folder.path() / "frame.ply", spiral(0)));
  const std::string url = "wss://127.0.0.1:9/live/stage";
  const auto expect = [&](const char* name, int exit_code, const std::string& fault) {
    const std::string file = (folder.path() / name).string();
    for (const Outcome& outcome :
         {run("pointreel-server",
              {"publish", "-i", folder.path().string(), "--to", url, "--ca-file", file}),
          run("pointreel", {"play", url, "--ca-file", file, "--offscreen", "64x64"})}) {
      EXPECT_EQ(outcome.exit_code, exit_code);
      EXPECT_THAT(outcome.err, testing::HasSubstr(fault));
      EXPECT_THAT(outcome.err, testing::HasSubstr(file));
      EXPECT_THAT(outcome.err, testing::Not(testing::HasSubstr("trying again")));
    }
  };
  expect("frame.ply", 1, "holds no certificates");
  expect("missing.pem", 2, "does not exist");
}

TEST(Live, a_publisher_without_the_token_is_refused_and_gives_up) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_ply(folder.path() / "frame.ply", spiral(0)));
  Background server("pointreel-server",
                    {"serve", "--live", "--publish-token", "secret", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const std::string url = "ws://" + address + "/live/stage";
  const std::vector<std::string> publish = {"publish", "-i", folder.path().string(), "--to", url};
  const Outcome refused = run("pointreel-server", publish);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, testing::HasSubstr("401"));
  std::vector<std::string> with_token = publish;
  with_token.insert(with_token.end(), {"--token", "secret", "--json"});
  const Outcome taken = run("pointreel-server", with_token);
  EXPECT_EQ(taken.exit_code, 0) << taken.err;
  EXPECT_THAT(taken.out, testing::HasSubstr("\"frames\": 1,"));
}

TEST(Live, a_viewer_without_the_token_is_refused_and_gives_up) {
  Background server("pointreel-server",
                    {"serve", "--live", "--view-token", "secret", "--listen", "127.0.0.1:0"});
  const std::string address = server_address(server);
  ASSERT_FALSE(address.empty());
  const std::string stage = "ws://" + address + "/live/stage", other = stage + "2";
  const std::string segments = "http://" + address + "/live/stage";
  for (const auto& sources :
       {std::vector{stage}, std::vector{stage, other}, std::vector{segments}}) {
    std::vector<std::string> play{"play", "--token", "wrong", "--offscreen", "64x64"};
    play.insert(play.end(), sources.begin(), sources.end());
    const Outcome refused = run("pointreel", play);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, testing::HasSubstr("401"));
    EXPECT_THAT(refused.err, testing::HasSubstr("it requires a valid token"));
    EXPECT_THAT(refused.err, testing::Not(testing::HasSubstr("trying again")));
    EXPECT_THAT(refused.err, testing::Not(testing::HasSubstr("waiting")));
  }
  // Not to be taken for a wrong token, or for a stream that nobody publishes.
  for (const auto& [program, arguments] :
       {std::pair{"pointreel", std::vector<std::string>{"play", "--offscreen", "64x64"}},
        std::pair{"pointreel-server",
                  std::vector<std::string>{"publish", "--input", "-", "--to"}}}) {
    std::vector<std::string> without_live = arguments;
    without_live.push_back("ws://" + address + "/stage");
    const Outcome wrong = run(program, without_live);
    EXPECT_NE(wrong.exit_code, 0);
    EXPECT_THAT(wrong.err, testing::HasSubstr("does not end in /live/ and a stream's name"));
  }
}

}  // namespace
}  // namespace pointreel::e2e::live_test
