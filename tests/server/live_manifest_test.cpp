// Whatever a publisher gets accepted, the manifests made of it are valid: those of recordings on
// disk, and those for viewers over HTTP.

#include <cfloat>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/core/reel_rules.h"
#include "codec/package/manifest.h"
#include "server/relay/http_window.h"
#include "server/relay/recorder.h"
#include "server/relay/relay.h"
#include "tests/live_frames.h"
#include "tests/temporary_folder.h"

namespace pointreel::live_manifest_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

/// What the publisher says about one frame, sensible unless it is changed.
struct Claim {
  LiveLayer layer;
  FrameHeader header;
  std::uint8_t layers = 1;

  std::vector<LiveMessage> messages() const {
    std::vector<LiveMessage> messages;
    LiveLayer each = layer;
    each.layers = layers;
    for (; each.layer < layers; ++each.layer) {
      Bytes bytes;
      if (each.layer == 0) write_frame_header(header, layer.frame, bytes);
      bytes.resize(bytes.size() + 5);
      each.sizes.geometry = static_cast<std::uint32_t>(bytes.size());
      bytes.resize(total(each.sizes));
      each.bytes = bytes;
      messages.push_back(
          {LiveMessage::Kind::binary, std::make_shared<const Bytes>(write_live_layer(each))});
    }
    return messages;
  }
};

/// A relay whose streams are recorded and served over HTTP, in the thread of the publisher.
class LiveManifestTest : public testing::Test {
 protected:
  LiveManifestTest() {
    RelayOptions options;
    options.grace = {};
    options.sinks = [this](const std::string& name) {
      LiveRecorderOptions recorder;
      recorder.folder = temporary_.path() / "recordings";
      recorder.name = name;
      recorder.say = [this](const std::string& line) { said_.push_back(line); };
      WindowOutput window;
      window.put = [this](const std::string& file, const std::string& content, bool) {
        if (file != kManifestName) return;
        const auto manifest = parse_manifest(content);
        ++windows_;
        if (!manifest) faults_.push_back("over HTTP: " + manifest.error().message);
      };
      window.remove = [](const std::string&) {};
      return std::vector<std::shared_ptr<LiveSink>>{
          std::make_shared<LiveRecorder>(std::move(recorder)),
          std::make_shared<HttpWindow>(std::move(window))};
    };
    relay_ = std::make_unique<Relay>(std::move(options));
  }

  /// Sends messages, and connects again after each that is refused.
  void send(const LiveMessage& message) {
    if (!publication_) publication_ = relay_->publish("stage").value();
    const bool text = message.kind == LiveMessage::Kind::text;
    if (const auto taken = publication_->message(message)) {
      ++(text ? hellos_ : layers_);
      if (text) hello_ = message;
    } else {
      refused_.push_back(taken.error().message);
      publication_.reset();
      if (text || !hello_.bytes) return;
      publication_ = relay_->publish("stage").value();
      EXPECT_TRUE(publication_->message(hello_));
    }
  }
  void send(const Claim& claim) {
    for (const LiveMessage& message : claim.messages()) send(message);
  }

  /// The faults of all manifests that were written.
  std::vector<std::string> faults() {
    publication_.reset();
    relay_.reset();
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(temporary_.path() / "recordings", none)) {
      ++recordings_;
      const auto manifest = read_manifest(entry.path());
      if (!manifest) faults_.push_back(manifest.error().message);
    }
    return faults_;
  }

  static LiveHello hello() {
    LiveHello hello = plain_hello();
    hello.colors = hello.normals = true;
    return hello;
  }
  static Claim claim(std::uint32_t frame) {
    Claim claim;
    claim.layer.frame = frame;
    claim.layer.capture_us = 1'000'000 + 400'000u * frame;
    claim.layer.points = claim.header.source_points = 4;
    return claim;
  }

  TemporaryFolder temporary_;
  std::unique_ptr<Relay> relay_;
  std::unique_ptr<Publication> publication_;
  LiveMessage hello_;
  std::vector<std::string> said_, faults_, refused_;
  int hellos_ = 0, layers_ = 0, windows_ = 0, recordings_ = 0;
};

TEST_F(LiveManifestTest,
       a_message_that_no_manifest_can_hold_is_refused_and_the_recording_continues) {
  send(publisher_message(1, hello()));
  std::uint32_t frame = 0;
  const auto good = [&] {
    for (int i = 0; i < 4; ++i) send(claim(frame++));
  };
  good();
  ASSERT_THAT(refused_, IsEmpty());
  const auto refused = [&](auto change) {
    Claim bad = claim(frame);
    change(bad);
    refused_.clear();
    send(bad);
    const std::string why = refused_.empty() ? "accepted" : refused_.front();
    good();
    return why;
  };
  EXPECT_THAT(refused([](Claim& c) { c.layer.capture_us = (std::uint64_t{1} << 53) - 1; }),
              HasSubstr("capture time"));
  EXPECT_THAT(refused([](Claim& c) { c.layer.capture_us = 0; }), HasSubstr("captured at 0 after"));
  Claim far = claim(frame++);
  far.header.cube.origin.x = DBL_MAX;
  send(far);
  EXPECT_THAT(refused([](Claim& c) { c.header.cube.origin.x = -DBL_MAX; }), HasSubstr("cube"));
  EXPECT_THAT(refused([](Claim& c) { c.header.codec = Codec::draco; }), HasSubstr("codec"));
  EXPECT_THAT(refused([](Claim& c) { c.layer.points = 5; }), HasSubstr("points"));
  LiveHello slow = hello();
  slow.fps = 1e-300;
  send(publisher_message(1, slow));
  EXPECT_THAT(refused_.back(), HasSubstr("fps"));
  LiveHello long_name = hello();
  long_name.layer_names = {std::string(250, 'b')};
  send(publisher_message(2, long_name));
  EXPECT_THAT(refused_.back(), HasSubstr("layers"));
  send(hello_);
  good();
  EXPECT_THAT(faults(), IsEmpty());
  EXPECT_THAT(said_, IsEmpty());
  const Manifest manifest = read_manifest(temporary_.path() / "recordings" / "stage").value();
  EXPECT_EQ(manifest.frame_count(), frame);
}

TEST_F(LiveManifestTest, the_farthest_values_that_are_accepted_give_valid_manifests) {
  LiveHello slowest = hello();
  slowest.fps = kMinFps;
  slowest.layer_names = {std::string(64, 'a'), std::string(64, 'b')};
  send(publisher_message(1, slowest));
  Claim first = claim(0), last = claim(~0u);
  first.layer.capture_us = 0;
  first.header.cube = {glm::dvec3(-DBL_MAX / 4), 1e30};
  last.layer.capture_us = kMaxCaptureTime;
  last.header.cube = {glm::dvec3(DBL_MAX / 2), 1e30};
  send(first);
  send(last);
  EXPECT_THAT(refused_, IsEmpty());
  EXPECT_THAT(faults(), IsEmpty());
  EXPECT_THAT(said_, IsEmpty());
  EXPECT_EQ(recordings_, 1);
}

TEST_F(LiveManifestTest, any_number_of_frames_in_no_time_gives_manifests_that_readers_accept) {
  send(publisher_message(1, hello()));
  for (std::uint32_t i = 0; i < 5'000; ++i) {
    Claim tiny = claim(i);
    tiny.layer.capture_us = 1'000'000 + i;
    send(tiny);
  }
  EXPECT_THAT(faults(), IsEmpty());
  EXPECT_GE(windows_, 5) << "a segment holds a bounded number of frames";
}

/// Values at which rules begin or end, and any others.
class Extremes {
 public:
  explicit Extremes(unsigned seed) : random_(seed) {}

  std::uint64_t below(std::uint64_t n) { return random_() % n; }
  bool once_in(int n) { return below(static_cast<std::uint64_t>(n)) == 0; }
  double real() {
    static constexpr double kReals[] = {0.0,     -0.0,          1.0,     -1.0,     1e-300,
                                        5e-324,  1e-30,         1e30,    1e31,     1e300,
                                        DBL_MAX, DBL_MAX / 2.0, 1.7e308, 8.98e307, INFINITY};
    const double value = kReals[below(std::size(kReals))];
    return once_in(2) ? -value : value;
  }
  std::uint64_t integer() {
    static constexpr std::uint64_t kIntegers[] = {0,
                                                  1,
                                                  0xffffffff,
                                                  0x100000000,
                                                  kMaxCaptureTime,
                                                  kMaxCaptureTime + 1,
                                                  (std::uint64_t{1} << 53) - 1,
                                                  std::uint64_t{1} << 53,
                                                  ~std::uint64_t{0}};
    return once_in(3) ? random_() : kIntegers[below(std::size(kIntegers))];
  }
  glm::dvec3 vector() { return {real(), real(), real()}; }

  void change(LiveHello& hello) {
    switch (below(8)) {
      case 0:
        hello.fps = std::abs(once_in(2) ? real() : std::exp2(40.0 - 80.0 * unit()));
        break;
      case 1:
        hello.bounds = {vector(), vector()};
        break;
      case 2:
        hello.bounds.grow(vector());
        break;
      case 3:
        (once_in(2) ? hello.colors : hello.normals) ^= true;
        break;
      case 4:
        hello.layer_names.assign(1 + below(9), std::string(1 + below(80), 'x'));
        for (std::string& name : hello.layer_names) name += std::to_string(below(100));
        break;
      case 5:
        hello.name.assign(below(300), once_in(8) ? '\n' : 'n');
        break;
      case 6:
        hello.codec = hello.codec == "draco" ? "octree" : "draco";
        hello.entropy = hello.codec == "draco" ? "" : "zstd";
        break;
      default:
        hello.up = once_in(2) ? 'y' : 'z';
    }
  }
  void change(Claim& claim) {
    switch (below(8)) {
      case 0:
        claim.layer.capture_us = integer();
        break;
      case 1:
        claim.header.cube.origin = vector();
        break;
      case 2:
        claim.header.cube.edge = real();
        break;
      case 3:
        claim.layer.points = claim.header.source_points = static_cast<std::uint32_t>(integer());
        break;
      case 4:
        claim.header.depth = static_cast<std::uint8_t>(below(24));
        break;
      case 5:
        claim.layers = static_cast<std::uint8_t>(1 + below(4));
        break;
      case 6:
        claim.layer.sizes.colors = static_cast<std::uint32_t>(below(20));
        claim.layer.sizes.normals = static_cast<std::uint32_t>(below(3));
        break;
      default:
        claim.layer.frame = static_cast<std::uint32_t>(integer());
    }
  }

 private:
  double unit() { return static_cast<double>(random_() % 1'000'000) * 1e-6; }
  std::mt19937_64 random_;
};

TEST_F(LiveManifestTest, whatever_is_accepted_gives_manifests_that_readers_accept) {
  constexpr int kStreams = 60, kMessages = 60;
  for (unsigned seed = 0; seed < kStreams; ++seed) {
    Extremes extremes(seed);
    const auto publisher = static_cast<std::uint8_t>(seed);
    LiveHello described = hello();
    publication_.reset();
    hello_ = publisher_message(publisher, described);
    send(hello_);
    std::uint32_t frame = 0;
    for (int i = 0; i < kMessages; ++i) {
      if (extremes.once_in(6)) {
        LiveHello changed = described;
        extremes.change(changed);
        const int before = hellos_;
        send(publisher_message(publisher, changed));
        if (hellos_ > before) described = changed;
        continue;
      }
      Claim next = claim(++frame);
      for (int changes = static_cast<int>(extremes.below(3)); changes > 0; --changes) {
        extremes.change(next);
      }
      send(next);
    }
  }
  const auto found = faults();
  EXPECT_THAT(found, IsEmpty());
  EXPECT_THAT(said_, IsEmpty());
  EXPECT_GT(hellos_, kStreams);
  EXPECT_GT(layers_, 10 * kStreams);
  EXPECT_GT(refused_.size(), 5u * kStreams);
  EXPECT_GE(recordings_, kStreams / 2);
  EXPECT_GT(windows_, kStreams);
}

}  // namespace
}  // namespace pointreel::live_manifest_test
