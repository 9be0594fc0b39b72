#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "server/serve/asio_types.h"
#include "server/serve/tls.h"

namespace pointreel {

/// A connected socket, with TLS on it or without, and the time by which something must have
/// happened on it. All of it runs on the socket's strand. Where a step returns false, the
/// connection has ended. One coroutine may read while another writes.
class Transport {
 public:
  /// `tls` is the socket's, or null. `patience`: until the first deadline is set. `stall`: how long
  /// the peer may take no byte of what is written to it.
  Transport(Socket socket, std::unique_ptr<TlsSession> tls, Clock::duration patience,
            Clock::duration stall);

  Strand executor() { return socket_.get_executor(); }
  Socket& socket() { return socket_; }
  TlsSession* tls() { return tls_.get(); }

  /// Closes the socket when a deadline passes; to be spawned once. One timer that is looked at when
  /// it ends, instead of one armed for each operation: deadlines nearly always move to later times.
  static Task<void> watch(std::shared_ptr<Transport> self);
  void set_deadline(Clock::duration from_now);
  /// For a peer that takes no byte of what is written.
  void set_stall_deadline() { set_deadline(stall_); }
  /// Nothing needs to happen until the next deadline is set.
  void suspend_deadline() { suspended_ = true; }
  void close();

  /// Agrees on keys; nothing to do without TLS.
  Task<bool> handshake();
  /// What has come, at least a byte; 0 if the connection ended.
  Task<std::size_t> read_some(asio::mutable_buffer into);
  /// `more` follows at once, so that both may leave in one packet.
  Task<bool> write(std::string_view text, bool more);
  /// Bytes `offset` to `offset + size` of a file. False, too, if it has become shorter.
  Task<bool> write_file(int file, std::uint64_t offset, std::uint64_t size);
  /// Tells the peer that nothing more comes.
  void end_writing();
  /// Ends writing, and reads for a while what still comes: closing a socket with unread bytes
  /// resets the connection, and the last response would be lost with it.
  Task<void> linger();

  /// What linger takes, and how long.
  static constexpr std::size_t kLingerBytes = 64 * 1024;
  static constexpr std::chrono::milliseconds kLingerTime{1000};

 private:
  Task<bool> ready(TlsSession::Step::Want want);
  Task<bool> write_encrypted(std::string_view text);
  Task<bool> write_file_encrypted(int file, std::uint64_t offset, std::uint64_t size);

  Socket socket_;
  std::unique_ptr<TlsSession> tls_;
  std::string held_;  ///< under TLS, what waits for more, so that both are in one record
  Timer timer_;
  Clock::time_point deadline_{};
  bool suspended_ = false;
  Clock::duration stall_;
};

}  // namespace pointreel
