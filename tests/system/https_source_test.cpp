// Packages over TLS: which servers the client trusts.

#include <memory>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/open_source.h"
#include "common/net/websocket.h"
#include "server/serve/http_server.h"
#include "tests/certificate.h"
#include "tests/served_package.h"

namespace pointreel::https_source_test {
namespace {

using testing::HasSubstr;

class HttpsSource : public testing::Test {
 protected:
  void SetUp() override {
    write_package(folder_ / "walk", patterned(1000), patterned(5000));
    serve("127.0.0.1");
  }
  void serve(const std::string& host) {
    HttpServerOptions options;
    options.listen.host = host;
    options.listen.port = 0;
    options.certificate = certificate_.certificate;
    options.key = certificate_.key;
    options.threads = 1;
    options.service.log = Log::Level::kOff;
    options.service.view_token = "open-sesame";
    auto server = HttpServer::start(*Catalog::load({folder_ / "walk"}), options);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
  }
  std::string url() const { return fmt::format("https://{}/walk", to_string(server_->address())); }
  std::string error(const SourceOptions& options) const {
    const auto source = open_source(url(), options);
    return source ? "none" : source.error().message;
  }
  std::string live_error(const std::string& ca_file) const {
    WebSocketOptions options;
    options.ca_file = ca_file;
    const auto socket = WebSocket::connect(
        fmt::format("wss://{}/live/walk", to_string(server_->address())), options);
    return socket ? "none" : socket.error().message;
  }

  TemporaryFolder folder_;
  TestCertificate certificate_{folder_.path()};
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HttpsSource, fetches_from_a_server_with_a_given_certificate) {
  SourceOptions options;
  options.ca_file = certificate_.certificate;
  options.token = "open-sesame";
  const auto source = open_source(url(), options);
  ASSERT_TRUE(source) << source.error().message;
  const auto frame = (*source)->fetch({0});
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->layers[0].bytes.size(), 1000u);
  EXPECT_EQ(frame->layers[1].bytes.size(), 5000u);
  EXPECT_THAT(live_error(certificate_.certificate), testing::Not(HasSubstr("certificate")));
}

TEST_F(HttpsSource, refuses_an_untrusted_certificate) {
  SourceOptions options;
  options.token = "open-sesame";
  EXPECT_THAT(error(options), HasSubstr("--ca-file"));
  EXPECT_THAT(live_error({}), HasSubstr("--ca-file"));
}

TEST_F(HttpsSource, says_that_a_certificate_was_made_for_another_name) {
  serve("127.0.0.2");
  SourceOptions options;
  options.ca_file = certificate_.certificate;
  EXPECT_THAT(error(options), HasSubstr("use a name that it was made for"));
  EXPECT_THAT(live_error(certificate_.certificate), HasSubstr("use a name that it was made for"));
}

TEST_F(HttpsSource, reports_that_a_file_contains_no_certificates) {
  SourceOptions options;
  options.ca_file = folder_.write("empty.pem", "nothing");
  EXPECT_THAT(error(options), HasSubstr("holds no certificates"));
  options.ca_file += ".missing";
  EXPECT_THAT(error(options), HasSubstr("empty.pem.missing: No such file"));
}

TEST_F(HttpsSource, reports_that_the_token_is_wrong) {
  SourceOptions options;
  options.ca_file = certificate_.certificate;
  EXPECT_THAT(error(options), HasSubstr("--token"));
  options.token = "open-barley";
  EXPECT_THAT(error(options), testing::Not(HasSubstr("none")));
}

}  // namespace
}  // namespace pointreel::https_source_test
