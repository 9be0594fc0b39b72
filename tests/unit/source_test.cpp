#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/source/open_source.h"
#include "tests/temporary_folder.h"

namespace pointreel {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
namespace fs = std::filesystem;

/// Two frames, two layers. Every byte of a layer's file is its own offset, so a test sees at once
/// from where bytes came.
Manifest small_manifest() {
  Manifest manifest;
  manifest.name = "small";
  manifest.codec = "octree";
  manifest.entropy = "none";
  manifest.fps = 10.0;
  manifest.duration_us = 200'000;
  manifest.colors = manifest.normals = true;
  manifest.depth_min = manifest.depth_max = 3;
  manifest.bounds.grow(glm::dvec3(0.0));
  manifest.bounds.grow(glm::dvec3(1.0));
  manifest.layer_names = {"base", "full"};
  Segment segment;
  segment.times_us = {0, 100'000};
  segment.points = {5, 6};
  segment.layers = {{"0.base.bin", 30, 1, {{4, 3, 2}, {10, 6, 5}}},
                    {"0.full.bin", 8, 2, {{5, 0, 0}, {1, 1, 1}}}};
  manifest.segments = {segment};
  return manifest;
}

Bytes offsets(std::size_t from, std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(from + i);
  return bytes;
}

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

/// An HTTP server of raw sockets on loopback, one thread a connection. The handler gets the head of
/// each request and the socket, and says whether the connection lives on.
class TestServer {
 public:
  using Handler = std::function<bool(int socket, const std::string& head)>;

  explicit TestServer(Handler handler) : handler_(std::move(handler)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    ::listen(listener_, 16);
    socklen_t size = sizeof address;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    acceptor_ = std::thread([this] {
      for (int client; (client = ::accept(listener_, nullptr, nullptr)) >= 0;) {
        ++connections;
        const std::lock_guard lock(mutex_);
        clients_.push_back(client);
        threads_.emplace_back([this, client] { serve(client); });
      }
    });
  }
  ~TestServer() {
    ::shutdown(listener_, SHUT_RDWR);
    acceptor_.join();
    ::close(listener_);
    for (const int client : clients_) ::shutdown(client, SHUT_RDWR);
    for (std::thread& thread : threads_) thread.join();
    for (const int client : clients_) ::close(client);
  }

  std::string url() const { return fmt::format("http://127.0.0.1:{}", port_); }

  std::atomic<int> connections{0}, requests{0};

 private:
  void serve(int client) {
    std::string buffer;
    char chunk[4096];
    for (;;) {
      std::size_t end;
      while ((end = buffer.find("\r\n\r\n")) == std::string::npos) {
        const ssize_t n = ::recv(client, chunk, sizeof chunk, 0);
        if (n <= 0) return;
        buffer.append(chunk, static_cast<std::size_t>(n));
      }
      ++requests;
      if (!handler_(client, buffer.substr(0, end))) break;
      buffer.erase(0, end + 4);
    }
    ::shutdown(client, SHUT_RDWR);
  }

  Handler handler_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::thread acceptor_;
  std::mutex mutex_;
  std::vector<std::thread> threads_;
  std::vector<int> clients_;
};

void send_text(int socket, const std::string& text) {
  ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
}

void answer(int socket, const std::string& status, const std::string& headers,
            const std::string& body) {
  send_text(socket, fmt::format("HTTP/1.1 {}\r\nContent-Length: {}\r\n{}\r\n{}", status,
                                body.size(), headers, body));
}

struct Range {
  std::size_t first, last;
};
Range range_of(const std::string& head) {
  const auto at = head.find("Range: bytes=");
  Range range{0, 0};
  std::sscanf(head.c_str() + at, "Range: bytes=%zu-%zu", &range.first, &range.last);
  return range;
}

/// Serves the small package; `layer` answers for its layer files.
TestServer::Handler serving(TestServer::Handler layer) {
  return [layer](int socket, const std::string& head) {
    if (!head.starts_with("GET /reel/reel.json ")) return layer(socket, head);
    answer(socket, "200 OK", "", write_manifest(small_manifest()));
    return true;
  };
}

bool serve_range(int socket, const std::string& head) {
  const Range range = range_of(head);
  const std::size_t total = head.find("base") != std::string::npos ? 30 : 8;
  answer(socket, "206 Partial Content",
         fmt::format("Content-Range: bytes {}-{}/{}\r\n", range.first, range.last, total),
         text_of(offsets(range.first, range.last - range.first + 1)));
  return true;
}

SourceOptions impatient() {
  SourceOptions options;
  options.connect_timeout = milliseconds(1000);
  options.transfer_timeout = milliseconds(300);
  options.first_backoff = milliseconds(1);
  options.attempts = 3;
  return options;
}

/// The error of fetching frame 0 where layer files are answered by `layer`.
std::string fetch_error(TestServer::Handler layer, int* requests = nullptr) {
  TestServer server(serving(std::move(layer)));
  auto source = open_source(server.url() + "/reel", impatient());
  if (!source) return "not opened: " + source.error().message;
  const auto fetched = (*source)->fetch(0, {});
  if (requests) *requests = server.requests - 1;
  return fetched ? "no error" : fetched.error().message;
}

TEST(FetchedLayer, SplitsIntoItsChunks) {
  const FetchedLayer layer{offsets(0, 9), {4, 3, 2}};
  const LayerView view = layer.view();
  EXPECT_EQ(Bytes(view.geometry.begin(), view.geometry.end()), offsets(0, 4));
  EXPECT_EQ(Bytes(view.colors.begin(), view.colors.end()), offsets(4, 3));
  EXPECT_EQ(Bytes(view.normals.begin(), view.normals.end()), offsets(7, 2));
}

TEST(Ranges, HoldAPrefixOfTheStoredOrder) {
  const Manifest manifest = small_manifest();
  const auto all = ranges_of(manifest, 1, {});
  ASSERT_EQ(all->size(), 2u);
  EXPECT_EQ((*all)[0].offset, 9u);
  EXPECT_EQ((*all)[0].sizes, (LayerSizes{10, 6, 5}));
  EXPECT_EQ((*all)[1].offset, 5u);
  EXPECT_EQ((*ranges_of(manifest, 1, {~0u, true, false}))[0].sizes, (LayerSizes{10, 6, 0}));
  EXPECT_EQ((*ranges_of(manifest, 1, {~0u, false, false}))[0].sizes, (LayerSizes{10, 0, 0}));
  EXPECT_EQ((*ranges_of(manifest, 1, {~0u, false, true}))[0].sizes, (LayerSizes{10, 6, 5}))
      << "normals lie behind the colours";
  EXPECT_EQ(ranges_of(manifest, 1, {1, true, true})->size(), 1u);
}

TEST(Ranges, RefuseAFrameThatNoReelHas) {
  Manifest manifest = small_manifest();
  manifest.segments[0].layers[0].frames[0].geometry = 0x7fffffff;
  EXPECT_FALSE(ranges_of(manifest, 0, {}));
}

TEST(OpenSource, SaysWhatIsWrongInOneLine) {
  EXPECT_THAT(open_source("/no/such/folder").error().message, HasSubstr("no such file or folder"));
  EXPECT_THAT(open_source("ftp://host/x").error().message, HasSubstr("ftp:// is not supported"));
  EXPECT_THAT(open_source("http://").error().message, HasSubstr("names no host"));
}

TEST(FileSource, ReadsTheWantedRanges) {
  const TemporaryFolder folder;
  folder.write("reel.json", write_manifest(small_manifest()));
  folder.write("0.base.bin", text_of(offsets(0, 30)));
  folder.write("0.full.bin", text_of(offsets(0, 8)));
  for (const fs::path& where : {folder.path(), folder.path() / "reel.json"}) {
    auto source = open_source(where.string());
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->manifest().name, "small");
    const auto frame = (*source)->fetch(1, {});
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->layers.size(), 2u);
    EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
    EXPECT_EQ(frame->layers[1].bytes, offsets(5, 3));
    EXPECT_EQ((*source)->fetch(0, {~0u, false, false})->layers[0].bytes, offsets(0, 4));
  }
}

TEST(FileSource, NamesAFileThatIsMissingOrTooShort) {
  const TemporaryFolder folder;
  folder.write("reel.json", write_manifest(small_manifest()));
  folder.write("0.base.bin", text_of(offsets(0, 29)));
  auto source = open_source(folder.path().string());
  ASSERT_TRUE(source);
  EXPECT_THAT((*source)->fetch(1, {}).error().message,
              testing::AllOf(HasSubstr("0.base.bin"), HasSubstr("29"), HasSubstr("30")));
  EXPECT_THAT((*source)->fetch(0, {}).error().message, HasSubstr("0.full.bin"));
}

TEST(FolderSource, TakesItsFilesInNaturalOrderAndItsTimesFromTheRate) {
  const TemporaryFolder folder;
  for (const int i : {1, 2, 10})
    folder.write(fmt::format("f{}.ply", i),
                 fmt::format("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty "
                             "float y\nproperty float z\nend_header\n0 0 0\n{} 2 3\n",
                             i));
  SourceOptions options;
  options.fps = 25.0;
  options.up = 'z';
  auto source = open_source(folder.path().string(), options);
  ASSERT_TRUE(source) << source.error().message;
  const Manifest& manifest = (*source)->manifest();
  EXPECT_EQ(manifest.frame_count(), 3u);
  EXPECT_EQ(manifest.up, 'z');
  EXPECT_EQ(manifest.duration_us, 120'000u);
  EXPECT_EQ(frame_time_us(manifest, 2), 80'000u);
  EXPECT_EQ(manifest.bounds.max, glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_FALSE(manifest.colors);
  EXPECT_THAT(text_of((*source)->fetch(1, {})->file), HasSubstr("\n2 2 3\n"));
  EXPECT_THAT(text_of((*source)->fetch(2, {})->file), HasSubstr("\n10 2 3\n"));
}

TEST(FolderSource, RefusesAFolderWithoutFrames) {
  const TemporaryFolder folder;
  EXPECT_FALSE(open_source(folder.path().string()));
}

TEST(HttpSource, FetchesTheWantedRangesOverOneConnection) {
  TestServer server(serving(serve_range));
  for (const std::string end : {"/reel", "/reel/", "/reel/reel.json"}) {
    server.connections = 0;
    auto source = open_source(server.url() + end, impatient());
    ASSERT_TRUE(source) << source.error().message;
    const auto frame = (*source)->fetch(1, {});
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
    EXPECT_EQ(frame->layers[1].bytes, offsets(5, 3));
    EXPECT_EQ(server.connections, 1);
  }
}

TEST(HttpSource, FetchesNoMoreThanWhatIsWanted) {
  TestServer server(serving(serve_range));
  auto source = open_source(server.url() + "/reel", impatient());
  const auto frame = (*source)->fetch(1, {1, false, false});
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->layers.size(), 1u);
  EXPECT_EQ(frame->layers[0].bytes, offsets(9, 10));
  EXPECT_EQ(frame->layers[0].sizes, (LayerSizes{10, 0, 0}));
}

TEST(HttpSource, ServesManyThreadsAtOnce) {
  TestServer server(serving(serve_range));
  auto source = open_source(server.url() + "/reel", impatient());
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        const auto frame = (*source)->fetch(1, {});
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->layers[0].bytes, offsets(9, 21));
      }
    });
  for (std::thread& thread : threads) thread.join();
}

TEST(HttpSource, TakesAWholeFileAsTheRangeThatCoversIt) {
  Manifest manifest = small_manifest();
  manifest.segments[0].times_us = {0};
  manifest.segments[0].points = {5};
  manifest.segments[0].layers = {{"0.base.bin", 9, 1, {{4, 3, 2}}},
                                 {"0.full.bin", 2, 2, {{2, 0, 0}}}};
  TestServer server([&](int socket, const std::string& head) {
    const auto has = [&](const char* name) { return head.find(name) != std::string::npos; };
    answer(socket, "200 OK", "",
           has("reel.json") ? write_manifest(manifest) : text_of(offsets(0, has("base") ? 9 : 2)));
    return true;
  });
  auto source = open_source(server.url(), impatient());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->fetch(0, {})->layers[0].bytes, offsets(0, 9));
}

TEST(HttpSource, SaysThatThereIsNoPackage) {
  TestServer server([](int socket, const std::string&) {
    answer(socket, "404 Not Found", "", "nothing");
    return true;
  });
  const auto source = open_source(server.url() + "/nowhere", impatient());
  EXPECT_THAT(source.error().message,
              testing::AllOf(HasSubstr("/nowhere/reel.json"), HasSubstr("404")));
  EXPECT_EQ(server.requests, 1) << "asking again would not help";
}

TEST(HttpSource, SaysThatAPageIsNoManifest) {
  TestServer server([](int socket, const std::string&) {
    answer(socket, "200 OK", "Content-Type: text/html\r\n", "<html>Welcome</html>");
    return true;
  });
  const auto source = open_source(server.url(), impatient());
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message, HasSubstr("/reel.json: "));
  EXPECT_EQ(source.error().message.find('\n'), std::string::npos);
}

TEST(HttpSource, SaysThatNobodyAnswers) {
  std::string url;
  {
    url = TestServer([](int, const std::string&) { return false; }).url();
  }
  EXPECT_THAT(open_source(url, impatient()).error().message, HasSubstr("nothing answers there"));
}

TEST(HttpSource, RefusesWholeFilesWhereARangeWasAskedFor) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "200 OK", "", text_of(offsets(0, 30)));
                return true;
              }),
              HasSubstr("Range"));
}

TEST(HttpSource, RefusesARangeThatWasNotAskedFor) {
  EXPECT_THAT(
      fetch_error([](int socket, const std::string& head) {
        const Range range = range_of(head);
        answer(socket, "206 Partial Content",
               fmt::format("Content-Range: bytes {}-{}/30\r\n", range.first + 1, range.last + 1),
               text_of(offsets(1, 9)));
        return true;
      }),
      HasSubstr("bytes 1-9/30"));
}

TEST(HttpSource, RefusesAnAnswerWithoutContentRange) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "206 Partial Content", "", text_of(offsets(0, 9)));
                return true;
              }),
              HasSubstr("the server sends \"\""));
}

TEST(HttpSource, RefusesAFileThatHasChangedItsSize) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "206 Partial Content", "Content-Range: bytes 0-8/31\r\n",
                       text_of(offsets(0, 9)));
                return true;
              }),
              HasSubstr("has changed"));
}

TEST(HttpSource, StopsReadingABodyThatIsTooLong) {
  EXPECT_THAT(fetch_error([](int socket, const std::string&) {
                answer(socket, "206 Partial Content", "Content-Range: bytes 0-8/30\r\n",
                       std::string(1 << 20, 'x'));
                return true;
              }),
              HasSubstr("more than the 9 bytes"));
}

TEST(HttpSource, TriesAgainWhenTheConnectionBreaksAndGivesUpInTheEnd) {
  int requests = 0;
  EXPECT_THAT(fetch_error(
                  [](int socket, const std::string&) {
                    send_text(socket,
                              "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-8/30\r\n"
                              "Content-Length: 9\r\n\r\nabc");
                    return false;
                  },
                  &requests),
              testing::AllOf(HasSubstr("broke after 3 bytes"), HasSubstr("3 attempts")));
  EXPECT_EQ(requests, 3);
}

TEST(HttpSource, RecoversWhenAnAttemptSucceeds) {
  std::atomic<int> asked{0};
  EXPECT_EQ(fetch_error([&](int socket, const std::string& head) {
              if (++asked == 1) return false;  // closes without a word
              if (asked == 2) {
                answer(socket, "503 Service Unavailable", "", "later");
                return true;
              }
              return serve_range(socket, head);
            }),
            "no error");
  EXPECT_EQ(asked, 4);  // two failures, then both layers
}

TEST(HttpSource, DoesNotWaitForeverForASilentServer) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(fetch_error([](int, const std::string&) { return true; }),
              HasSubstr("not complete after 0.3 s"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(8));
}

TEST(HttpSource, FailsAtOnceAfterCancel) {
  TestServer server(serving([](int, const std::string&) { return true; }));
  SourceOptions patient = impatient();
  patient.transfer_timeout = std::chrono::seconds(60);
  auto source = open_source(server.url() + "/reel", patient);
  std::thread canceller([&] {
    std::this_thread::sleep_for(milliseconds(50));
    (*source)->cancel();
  });
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT((*source)->fetch(0, {}).error().message, HasSubstr("cancelled"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  canceller.join();
}

}  // namespace
}  // namespace pointreel
