#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "pointreel/error.h"

struct ssl_ctx_st;
struct ssl_st;

/// The server's side of TLS 1.2 and 1.3, by OpenSSL, over sockets that do not block.
namespace pointreel {

/// One connection's. What it gives and takes is plain; on the socket it is encrypted.
class TlsSession {
 public:
  /// What a step did. `bytes` moved if it was more than none; else what must be possible on the
  /// socket before it is tried again with the same arguments.
  struct Step {
    enum class Want { kNothing, kRead, kWrite, kEnd };
    Want want = Want::kNothing;
    std::size_t bytes = 0;
  };

  Step handshake();
  Step read(std::span<char> into);
  Step write(std::string_view text);
  /// Tells the peer that nothing more comes.
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

/// The certificate that the server shows.
class TlsContext {
 public:
  /// PEM files: the certificate, and behind it those that signed it; and its key, without password.
  static Result<TlsContext> load(const std::filesystem::path& certificate,
                                 const std::filesystem::path& key);

  /// On an open socket, which must outlive it; null if there is no memory for it.
  std::unique_ptr<TlsSession> session(int socket) const;

 private:
  struct Free {
    void operator()(ssl_ctx_st* context) const;
  };
  std::unique_ptr<ssl_ctx_st, Free> context_;
};

}  // namespace pointreel
