#pragma once

#include <filesystem>
#include <memory>

#include <openssl/ssl.h>
#include <sys/time.h>

#include "tests/raw_http_client.h"

/// The same over TLS. The server's certificate is verified.
class TlsHttpClient : public RawHttpClient {
 public:
  TlsHttpClient(std::uint16_t port, const std::filesystem::path& authority, int receive_buffer = 0)
      : RawHttpClient(port, receive_buffer),
        context_(SSL_CTX_new(TLS_client_method()), SSL_CTX_free),
        ssl_(nullptr, SSL_free) {
    const timeval patience{10, 0};
    ::setsockopt(socket(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    SSL_CTX_load_verify_locations(context_.get(), authority.c_str(), nullptr);
    SSL_CTX_set_verify(context_.get(), SSL_VERIFY_PEER, nullptr);
    ssl_.reset(SSL_new(context_.get()));
    SSL_set1_host(ssl_.get(), "localhost");
    SSL_set_fd(ssl_.get(), socket());
    met_ = SSL_connect(ssl_.get()) == 1;
  }
  bool met() const { return met_; }

 protected:
  ssize_t put(const char* bytes, std::size_t size) override {
    return met_ ? SSL_write(ssl_.get(), bytes, static_cast<int>(size)) : -1;
  }
  ssize_t take(char* bytes, std::size_t size) override {
    return met_ ? SSL_read(ssl_.get(), bytes, static_cast<int>(size)) : -1;
  }
  bool holds_bytes() override { return SSL_has_pending(ssl_.get()) == 1; }

 private:
  std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context_;
  std::unique_ptr<SSL, decltype(&SSL_free)> ssl_;
  bool met_ = false;
};
