#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "server/serve/asio_types.h"
#include "server/serve/tls.h"

namespace pointreel {

/// A connected socket, plain or with TLS, and a deadline by which something must have happened on
/// it. Everything runs on the socket's strand. If a step returns false, the connection has ended.
/// One coroutine may read while another writes.
class Transport {
 public:
  /// `tls` may be null. `patience` is the time to the first deadline, and `stall` how long the peer
  /// may accept no byte of what is written to it.
  Transport(Socket socket, std::unique_ptr<TlsSession> tls, Clock::duration patience,
            Clock::duration stall);

  Strand executor() { return socket_.get_executor(); }
  Socket& socket() { return socket_; }
  TlsSession* tls() { return tls_.get(); }

  /// Closes the socket when a deadline passes. Must be spawned once. Deadlines nearly always move
  /// to later times, so the timer is not set again for each of them; instead the deadline is
  /// checked whenever the timer expires.
  static Task<void> watch(std::shared_ptr<Transport> self);
  void set_deadline(Clock::duration from_now);
  /// Sets the deadline for a peer that accepts no byte of what is written to it.
  void set_stall_deadline() { set_deadline(stall_); }
  /// Removes the deadline until the next one is set.
  void suspend_deadline() { suspended_ = true; }
  void close();

  /// The handshake of TLS; does nothing on a plain socket.
  Task<bool> handshake();
  /// Reads at least one byte; 0 if the connection has ended.
  Task<std::size_t> read_some(asio::mutable_buffer into);
  /// `more` says that another write follows at once, so that both can leave in one packet.
  Task<bool> write(std::string_view text, bool more);
  /// Writes `size` bytes of a file from `offset`. Also returns false if the file has become
  /// shorter.
  Task<bool> write_file(int file, std::uint64_t offset, std::uint64_t size);
  /// Tells the peer that nothing more will come.
  void end_writing();
  /// Ends writing, and reads for a while what still arrives: closing a socket with unread bytes
  /// resets the connection, and the last response could be lost.
  Task<void> linger();

  /// How many bytes linger reads, and how long it waits.
  static constexpr std::size_t kLingerBytes = 64 * 1024;
  static constexpr std::chrono::milliseconds kLingerTime{1000};

 private:
  Task<bool> ready(TlsSession::Step::Want want);
  Task<bool> write_encrypted(std::string_view text);
  Task<bool> write_file_encrypted(int file, std::uint64_t offset, std::uint64_t size);

  Socket socket_;
  std::unique_ptr<TlsSession> tls_;
  std::string held_;  ///< with TLS: written with `more`, and waits to be sent in one record
  Timer timer_;
  Clock::time_point deadline_{};
  bool suspended_ = false;
  Clock::duration stall_;
};

}  // namespace pointreel
