#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "pointreel/error.h"

struct ssl_ctx_st;
struct ssl_st;

/// The server's side of TLS 1.2 and 1.3, with OpenSSL, over non-blocking sockets.
namespace pointreel {

/// TLS on one connection. Its arguments and results are plain; the socket carries encrypted bytes.
class TlsSession {
 public:
  /// The result of a step: how many plain bytes were moved; or, if none, what the socket must be
  /// ready for before the step is repeated with the same arguments.
  struct Step {
    enum class Want { kNothing, kRead, kWrite, kEnd };
    Want want = Want::kNothing;
    std::size_t bytes = 0;
  };

  Step handshake();
  Step read(std::span<char> into);
  Step write(std::string_view text);
  /// Tells the peer that nothing more will come.
  void end_writing();

 private:
  friend class TlsContext;
  struct Free {
    void operator()(ssl_st* ssl) const;
  };
  explicit TlsSession(ssl_st* ssl) : ssl_(ssl) {}
  Step step(int result);

  std::unique_ptr<ssl_st, Free> ssl_;
};

/// The server's certificate.
class TlsContext {
 public:
  /// Both are PEM files: the certificate, followed by those that signed it, and its key without a
  /// password.
  static Result<TlsContext> load(const std::filesystem::path& certificate,
                                 const std::filesystem::path& key);

  /// A session on an open socket, which must outlive it; null if there is no memory for it.
  std::unique_ptr<TlsSession> session(int socket) const;

 private:
  struct Free {
    void operator()(ssl_ctx_st* context) const;
  };
  std::unique_ptr<ssl_ctx_st, Free> context_;
};

}  // namespace pointreel
