// The server over TLS: the same responses, and peers that do not speak TLS.

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "server/serve/http_server.h"
#include "tests/certificate.h"
#include "tests/served_package.h"
#include "tests/server/tls_http_client.h"
#include "tests/wait.h"

namespace pointreel::tls_server_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using Answer = RawHttpClient::Answer;

class TlsServerTest : public testing::Test {
 protected:
  TlsServerTest() {
    // OpenSSL writes to sockets even if the peer has closed them.
    std::signal(SIGPIPE, SIG_IGN);
    write_package(reel_, base_, full_);
    options_.certificate = certificate_.certificate;
    options_.key = certificate_.key;
    options_.threads = 2;
    options_.service.log = Log::Level::kOff;
    options_.listen.port = 0;
  }
  void start() {
    auto server = HttpServer::start(*Catalog::load({reel_}), options_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
  }
  std::unique_ptr<TlsHttpClient> client(int receive_buffer = 0) {
    return std::make_unique<TlsHttpClient>(server_->port(), certificate_.certificate,
                                           receive_buffer);
  }
  bool becomes_empty() {
    return wait_until([&] { return server_->connection_count() == 0; });
  }

  TemporaryFolder temporary_;
  fs::path reel_ = temporary_.path() / "walk";
  std::string base_ = patterned(1000), full_ = patterned(700'001);
  TestCertificate certificate_{temporary_.path()};
  HttpServerOptions options_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(TlsServerTest, serves_texts_files_and_ranges_on_one_connection) {
  start();
  const auto peer = client();
  ASSERT_TRUE(peer->met());
  EXPECT_EQ(peer->get("/healthz").body, "ok\n");
  EXPECT_TRUE(peer->get("/walk/0.full.prs").body == full_);
  const Answer part = peer->get("/walk/0.full.prs", "Range: bytes=16000-33000\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_TRUE(part.body == full_.substr(16000, 17001));
  EXPECT_EQ(peer->get("/missing").status, 404);
  EXPECT_EQ(peer->request("HEAD", "/walk/0.full.prs").field("content-length"), "700001");
  EXPECT_EQ(peer->get("/walk/0.base.prs", "Connection: close\r\n").body, base_);
  EXPECT_TRUE(peer->ends());
}

TEST_F(TlsServerTest, answers_pipelined_requests_and_waits_for_slow_readers) {
  full_ = patterned(8 << 20);
  write_package(reel_, base_, full_);
  options_.header_timeout = options_.idle_timeout = 800ms;
  start();
  const auto peer = client(4096);
  ASSERT_TRUE(
      peer->send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n"
                 "GET /walk/0.base.prs HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  ASSERT_TRUE(peer->has_something());
  // The server is stuck in the middle of a record. A later connection is closed because it is
  // silent: by then, the reader's timeouts would have passed too.
  EXPECT_TRUE(RawHttpClient(server_->port()).ends());
  EXPECT_TRUE(peer->read_answer().body == full_);
  EXPECT_EQ(peer->read_answer().body, base_);
}

TEST_F(TlsServerTest, drops_peers_that_do_not_speak_tls_or_stop_in_the_handshake) {
  options_.header_timeout = 800ms;
  start();
  RawHttpClient plain(server_->port());
  plain.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(plain.read_answer().status, 0);
  RawHttpClient half(server_->port());
  half.send(std::string("\x16\x03\x01\x02", 4));
  RawHttpClient silent(server_->port());
  EXPECT_TRUE(half.ends());
  EXPECT_TRUE(silent.ends());
  EXPECT_EQ(client()->get("/healthz").status, 200);
  EXPECT_TRUE(becomes_empty());
}

TEST_F(TlsServerTest, survives_readers_that_disconnect_in_the_middle) {
  full_ = patterned(8 << 20);
  write_package(reel_, base_, full_);
  start();
  for (int i = 0; i < 20; ++i) {
    client()->send("GET /walk/0.full.prs HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  EXPECT_EQ(client()->get("/healthz").status, 200);
  EXPECT_TRUE(becomes_empty());
}

TEST_F(TlsServerTest, refuses_connections_beyond_its_limit) {
  options_.max_connections = 1;
  start();
  const auto busy = client();
  ASSERT_TRUE(busy->send("GET / HT"));
  EXPECT_EQ(client()->get("/healthz").status, 503);
}

TEST_F(TlsServerTest, a_renewed_certificate_is_for_new_connections_and_a_bad_one_changes_nothing) {
  start();
  const auto before = client();
  ASSERT_TRUE(before->met());
  fs::create_directory(temporary_.path() / "new");
  const TestCertificate renewed(temporary_.path() / "new");
  const auto meets = [&](const TestCertificate& trusted) {
    return TlsHttpClient(server_->port(), trusted.certificate, 0).met();
  };
  EXPECT_FALSE(server_->read_certificate(renewed.certificate, certificate_.key));
  EXPECT_FALSE(server_->read_certificate({}, {})) << "a server with TLS keeps it";
  const fs::path pipe = temporary_.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(server_->read_certificate(certificate_.certificate, pipe).error().message,
              HasSubstr("pipe: is a pipe"));
  EXPECT_TRUE(meets(certificate_));
  const auto read = server_->read_certificate(renewed.certificate, renewed.key);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(meets(renewed));
  EXPECT_FALSE(meets(certificate_));
  EXPECT_EQ(before->get("/healthz").body, "ok\n") << "connections stay";
}

TEST_F(TlsServerTest, reports_certificate_problems_in_one_line) {
  const auto failure = [&] {
    const auto server = HttpServer::start({}, options_);
    return server ? "it started" : server.error().message;
  };
  options_.certificate = temporary_.path() / "none.pem";
  EXPECT_THAT(failure(), HasSubstr("none.pem: No such file or directory"));
  options_.certificate = certificate_.key;
  EXPECT_THAT(failure(), HasSubstr("give a certificate in PEM form"));
  options_.certificate = certificate_.certificate;
  fs::create_directory(temporary_.path() / "other");
  options_.key = TestCertificate(temporary_.path() / "other").key;
  EXPECT_THAT(failure(), HasSubstr("key values mismatch"));
  options_.key = temporary_.path() / "rsa.pem";
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> rsa(EVP_RSA_gen(2048), EVP_PKEY_free);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(options_.key.c_str(), "w"),
                                                             std::fclose);
  PEM_write_PrivateKey(file.get(), rsa.get(), nullptr, nullptr, 0, nullptr, nullptr);
  std::fflush(file.get());
  EXPECT_THAT(failure(), HasSubstr("rsa.pem: is not the key of")) << "a key of another type";
}

}  // namespace
}  // namespace pointreel::tls_server_test
