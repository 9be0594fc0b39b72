#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "server/serve/http_server.h"
#include "server/service/entity_tag.h"
#include "tests/raw_http_client.h"
#include "tests/served_package.h"
#include "tests/wait.h"

namespace pointreel {

/// Larger than all socket buffers between server and client together.
inline constexpr std::size_t kBig = 16 << 20;

/// Runs the server in this process with real sockets on 127.0.0.1.
class HttpServerTest : public testing::Test {
 protected:
  HttpServerTest() { write_package(reel_, base_, full_); }

  void start(HttpServerOptions options = {}) {
    options.listen.port = 0;
    options.service.log = Log::Level::kOff;
    if (options.threads == 0) options.threads = 2;
    auto catalog = Catalog::load({reel_});
    ASSERT_TRUE(catalog) << catalog.error().message;
    auto server = HttpServer::start(*std::move(catalog), options);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
  }
  std::uint16_t port() const { return server_->port(); }
  RawHttpClient::Answer get(const std::string& target, const std::string& fields = "") {
    return RawHttpClient(port()).get(target, fields);
  }

  static std::size_t open_descriptors() {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
      ++count;
    return count;
  }

  TemporaryFolder temporary_;
  std::filesystem::path reel_ = temporary_.path() / "walk";
  std::string base_ = patterned(1000), full_ = patterned(700'001);
  std::string base_tag_ = make_etag(checksum_of_text(base_));
  std::unique_ptr<HttpServer> server_;
};

}  // namespace pointreel
