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

namespace pointreel {
namespace {

/// Between two looks at what else there is to do.
constexpr std::uint64_t kPieceSize = 256 * 1024;
/// Bytes that the kernel may hold for a connection beyond what is in flight.
constexpr int kUnsentLimit = 256 * 1024;

}  // namespace

Transport::Transport(Socket socket, Clock::duration patience, Clock::duration stall)
    : socket_(std::move(socket)),
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
    if (Clock::now() >= self->deadline_) {
      self->close();
      break;
    }
    self->timer_.expires_at(self->deadline_);
    error_code ignored;
    co_await self->timer_.async_wait(asio::redirect_error(kUseAwaitable, ignored));
  }
}

void Transport::set_deadline(Clock::duration from_now) {
  deadline_ = Clock::now() + from_now;
  if (deadline_ < timer_.expiry()) timer_.cancel();
}

void Transport::close() {
  error_code ignored;
  socket_.close(ignored);
  timer_.cancel();
}

Task<std::size_t> Transport::read_some(asio::mutable_buffer into) {
  error_code error;
  const std::size_t size =
      co_await socket_.async_read_some(into, asio::redirect_error(kUseAwaitable, error));
  co_return error ? 0 : size;
}

Task<bool> Transport::writable() {
  error_code error;
  co_await socket_.async_wait(Socket::wait_write, asio::redirect_error(kUseAwaitable, error));
  co_return !error;
}

Task<bool> Transport::write(std::string_view text, bool more) {
  set_deadline(stall_);
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
    if (errno != EAGAIN || !co_await writable()) co_return false;
  }
  co_return true;
}

Task<bool> Transport::write_file(int file, std::uint64_t offset, std::uint64_t size) {
  set_deadline(stall_);
  off_t at = static_cast<off_t>(offset);
  while (size > 0) {
    const ssize_t sent = ::sendfile(socket_.native_handle(), file, &at,
                                    static_cast<std::size_t>(std::min(size, kPieceSize)));
    if (sent > 0) {
      size -= static_cast<std::uint64_t>(sent);
      set_deadline(stall_);
      // A reader as fast as the disk must not keep a thread from everybody else.
      if (size > 0) co_await asio::post(socket_.get_executor(), kUseAwaitable);
      if (!socket_.is_open()) co_return false;
      continue;
    }
    if (sent == 0) co_return false;  // the file shrank: too late for anything but a short answer
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !co_await writable()) co_return false;
  }
  co_return true;
}

Task<void> Transport::linger() {
  error_code error;
  socket_.shutdown(Socket::shutdown_send, error);
  set_deadline(kLingerTime);
  std::array<char, 4096> unread;
  for (std::size_t total = 0; !error && total < kLingerBytes;) {
    total += co_await socket_.async_read_some(asio::buffer(unread),
                                              asio::redirect_error(kUseAwaitable, error));
  }
}

}  // namespace pointreel
