#include "server/serve/transport.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <netinet/tcp.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <unistd.h>

namespace pointreel {
namespace {

/// After this many bytes of a file, plain or encrypted, other connections get their turn.
constexpr std::uint64_t kPieceSize = 1024 * 1024;
constexpr std::uint64_t kEncryptedPieceSize = 256 * 1024;
/// How many bytes the kernel may hold for a connection in addition to those in flight.
constexpr int kUnsentLimit = 256 * 1024;
/// Plain bytes in the longest record of TLS.
constexpr std::size_t kRecordSize = 16 * 1024;

using Want = TlsSession::Step::Want;

}  // namespace

Transport::Transport(Socket socket, std::unique_ptr<TlsSession> tls, Clock::duration patience,
                     Clock::duration stall)
    : socket_(std::move(socket)),
      tls_(std::move(tls)),
      timer_(socket_.get_executor()),
      deadline_(Clock::now() + patience),
      stall_(stall) {
  error_code ignored;
  socket_.native_non_blocking(true, ignored);
  socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
  ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentLimit,
               sizeof(kUnsentLimit));
}

Task<void> Transport::watch(std::shared_ptr<Transport> self) {
  while (self->socket_.is_open()) {
    if (const auto now = Clock::now(); now >= self->deadline_) {
      if (!self->suspended_) {
        self->close();
        break;
      }
      // The next deadline, once it is set, cannot pass before this.
      self->deadline_ = now + self->stall_;
    }
    self->timer_.expires_at(self->deadline_);
    error_code ignored;
    co_await self->timer_.async_wait(asio::redirect_error(kUseAwaitable, ignored));
  }
}

void Transport::set_deadline(Clock::duration from_now) {
  suspended_ = false;
  deadline_ = Clock::now() + from_now;
  if (deadline_ < timer_.expiry()) timer_.cancel();
}

void Transport::close() {
  error_code ignored;
  socket_.close(ignored);
  timer_.cancel();
}

Task<bool> Transport::ready(Want want) {
  if (want == Want::kEnd || !socket_.is_open()) co_return false;
  error_code error;
  co_await socket_.async_wait(want == Want::kRead ? Socket::wait_read : Socket::wait_write,
                              asio::redirect_error(kUseAwaitable, error));
  co_return !error && socket_.is_open();
}

Task<bool> Transport::handshake() {
  while (tls_) {
    const TlsSession::Step step = tls_->handshake();
    if (step.want == Want::kNothing) break;
    if (!co_await ready(step.want)) co_return false;
  }
  co_return true;
}

Task<std::size_t> Transport::read_some(asio::mutable_buffer into) {
  // Once the socket is closed, the descriptor that TLS holds may belong to another connection.
  while (tls_) {
    if (!socket_.is_open()) co_return 0;
    const auto step = tls_->read({static_cast<char*>(into.data()), into.size()});
    if (step.bytes > 0) co_return step.bytes;
    if (!co_await ready(step.want)) co_return 0;
  }
  error_code error;
  const std::size_t size =
      co_await socket_.async_read_some(into, asio::redirect_error(kUseAwaitable, error));
  co_return error ? 0 : size;
}

Task<bool> Transport::write(std::string_view text, bool more) {
  set_deadline(stall_);
  if (tls_) {
    held_ += text;
    if (more) co_return true;
    const std::string whole = std::exchange(held_, {});
    co_return co_await write_encrypted(whole);
  }
  while (!text.empty()) {
    const ssize_t sent =
        ::send(socket_.native_handle(), text.data(), std::min<std::size_t>(text.size(), kPieceSize),
               (more ? MSG_MORE : 0) | MSG_NOSIGNAL);
    if (sent > 0) {
      text.remove_prefix(static_cast<std::size_t>(sent));
      set_deadline(stall_);
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !co_await ready(Want::kWrite)) co_return false;
  }
  co_return true;
}

Task<bool> Transport::write_encrypted(std::string_view text) {
  while (!text.empty()) {
    if (!socket_.is_open()) co_return false;
    const auto step = tls_->write(text);
    text.remove_prefix(step.bytes);
    if (step.bytes > 0) {
      set_deadline(stall_);
    } else if (!co_await ready(step.want)) {
      co_return false;
    }
  }
  co_return true;
}

Task<bool> Transport::write_file(int file, std::uint64_t offset, std::uint64_t size) {
  set_deadline(stall_);
  if (tls_) co_return co_await write_file_encrypted(file, offset, size);
  off_t at = static_cast<off_t>(offset);
  while (size > 0) {
    const ssize_t sent = ::sendfile(socket_.native_handle(), file, &at,
                                    static_cast<std::size_t>(std::min(size, kPieceSize)));
    if (sent > 0) {
      size -= static_cast<std::uint64_t>(sent);
      set_deadline(stall_);
      // A peer that reads as fast as the disk must not keep the thread from other connections.
      if (size > 0) co_await asio::post(socket_.get_executor(), kUseAwaitable);
      if (!socket_.is_open()) co_return false;
      continue;
    }
    if (sent == 0) co_return false;  // the file has shrunk, so the response ends too early
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !co_await ready(Want::kWrite)) co_return false;
  }
  co_return true;
}

Task<bool> Transport::write_file_encrypted(int file, std::uint64_t offset, std::uint64_t size) {
  std::string piece = std::exchange(held_, {});
  if (piece.size() >= kRecordSize) {
    if (!co_await write_encrypted(piece)) co_return false;
    piece.clear();
  }
  std::uint64_t since_pause = 0;
  while (size > 0) {
    const std::size_t before = piece.size();
    piece.resize(before + std::min<std::uint64_t>(size, kRecordSize - before));
    const ssize_t got =
        ::pread(file, piece.data() + before, piece.size() - before, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) {
      piece.resize(before);
      continue;
    }
    if (got <= 0) co_return false;
    piece.resize(before + static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
    size -= static_cast<std::uint64_t>(got);
    if (!co_await write_encrypted(piece)) co_return false;
    since_pause += piece.size();
    piece.clear();
    if (since_pause < kEncryptedPieceSize) continue;
    since_pause = 0;
    co_await asio::post(socket_.get_executor(), kUseAwaitable);
  }
  co_return piece.empty() || co_await write_encrypted(piece);
}

void Transport::end_writing() {
  if (tls_ && socket_.is_open()) tls_->end_writing();
  error_code ignored;
  socket_.shutdown(Socket::shutdown_send, ignored);
}

Task<void> Transport::linger() {
  end_writing();
  error_code error;
  set_deadline(kLingerTime);
  std::array<char, 4096> unread;
  for (std::size_t total = 0; !error && total < kLingerBytes;) {
    total += co_await socket_.async_read_some(asio::buffer(unread),
                                              asio::redirect_error(kUseAwaitable, error));
  }
}

}  // namespace pointreel
