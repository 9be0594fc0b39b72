#include "tests/link/link_emulator.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <deque>
#include <list>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "common/base/try.h"

namespace pointreel {
namespace {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;

/// The size of the sockets' buffers. They are small, so that bytes that wait for the link wait in
/// their sender.
constexpr int kSocketBuffer = 64 * 1024;
/// The link accepts bytes for this long in advance.
constexpr auto kLinkQueue = std::chrono::milliseconds(5);
constexpr std::size_t kLargestPiece = 64 * 1024, kSmallestPiece = 1500;
/// The most bytes that wait for a receiver that does not read, in addition to those in transit.
constexpr std::uint64_t kMostWaiting = 128 * 1024;
/// The rate in bits per second that is assumed for a link without a limit.
constexpr std::uint64_t kFastest = 2'000'000'000;

void close_with_reset(int socket) {
  if (socket < 0) return;
  const linger hard{1, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
  ::close(socket);
}

}  // namespace

/// What the loop consists of.
namespace link_emulator {

struct Piece {
  Time due;
  std::vector<char> bytes;
  std::size_t sent = 0;
};

/// One direction of a connection: the bytes from one socket to the other, each with the time when
/// it is due.
struct Direction {
  int from = -1, to = -1;
  bool readable = false, writable = false;  ///< true until a call says EAGAIN
  bool ended = false;                       ///< the sender has closed its side
  bool end_passed_on = false;
  std::optional<Time> end_due;
  Time not_before{};  ///< the time when the connection is established
  Time free_at{};     ///< when the link is free again, if each connection has its own rate
  std::deque<Piece> pieces;
  std::size_t in_flight = 0;
  std::uint64_t passed = 0;
};

struct Connection {
  int client = -1, target = -1;
  bool forgotten = false, broken = false;
  Direction up, down;
};

}  // namespace link_emulator

using namespace link_emulator;

class LinkEmulator::Loop {
 public:
  ~Loop() {
    if (thread_.joinable()) {
      stopping_ = true;
      wake();
      thread_.join();
    }
    for (Connection& connection : connections_) {
      close_with_reset(connection.client);
      close_with_reset(connection.target);
    }
    for (const int descriptor : {listener_, epoll_, wake_, timer_})
      if (descriptor >= 0) ::close(descriptor);
  }

  Result<void> open(const Options& options) {
    conditions_ = options.conditions;
    random_.seed(options.seed);
    TRY(set_target(options.target));
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int on = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &kSocketBuffer, sizeof kSocketBuffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(options.port);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::listen(listener_, 1024) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      return fail(ErrorCode::io, fmt::format("127.0.0.1:{}: cannot listen: {}", options.port,
                                             std::strerror(errno)));
    port_ = ntohs(address.sin_port);
    epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
    wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    timer_ = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
    if (epoll_ < 0 || wake_ < 0 || timer_ < 0)
      return fail(ErrorCode::io, fmt::format("the link cannot start: {}", std::strerror(errno)));
    for (int* descriptor : {&listener_, &wake_, &timer_}) watch(*descriptor, EPOLLIN, descriptor);
    thread_ = std::thread([this] { run(); });
    return {};
  }

  std::uint16_t port() const { return port_; }

  void set(const LinkConditions& conditions) {
    {
      const std::lock_guard lock(mutex_);
      conditions_ = conditions;
    }
    wake();
  }
  LinkConditions conditions() const {
    const std::lock_guard lock(mutex_);
    return conditions_;
  }

  Result<void> set_target(const std::string& target) {
    const auto colon = target.rfind(':');
    if (colon == std::string::npos) {
      return fail(ErrorCode::argument, target + ": is not of the form HOST:PORT");
    }
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    std::string host = target.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    if (const int code =
            ::getaddrinfo(host.c_str(), target.substr(colon + 1).c_str(), &hints, &found);
        code != 0)
      return fail(ErrorCode::io, fmt::format("{}: {}", target, ::gai_strerror(code)));
    const std::lock_guard lock(mutex_);
    std::memcpy(&target_, found->ai_addr, found->ai_addrlen);
    target_size_ = found->ai_addrlen;
    ::freeaddrinfo(found);
    return {};
  }

  void reset_connections() { request(reset_); }
  void forget_connections() { request(forget_); }

  Result<void> start_script(const LinkScript& script) {
    std::vector<std::pair<Time, LinkChange>> events;
    const Time now = Clock::now();
    for (const LinkEvent& event : script) {
      events.emplace_back(now + event.at, TRY(parse_link_change(event.what)));
    }
    std::stable_sort(events.begin(), events.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    {
      const std::lock_guard lock(mutex_);
      script_.assign(events.begin(), events.end());
    }
    wake();
    return {};
  }

  LinkStatistics statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
  }

 private:
  void wake() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t n = ::write(wake_, &one, sizeof one);
  }

  void request(bool& flag) {
    {
      const std::lock_guard lock(mutex_);
      flag = true;
    }
    wake();
  }

  /// Adds a descriptor to epoll; its events carry the pointer `owner`.
  void watch(int descriptor, std::uint32_t events, void* owner) {
    epoll_event event{};
    event.events = events;
    event.data.ptr = owner;
    ::epoll_ctl(epoll_, EPOLL_CTL_ADD, descriptor, &event);
  }

  /// Ends a connection for this process and its events for everyone: a descriptor stays in epoll
  /// after it was closed if a forked process still has a copy.
  void close(const Connection& connection) {
    for (const int socket : {connection.client, connection.target}) {
      ::epoll_ctl(epoll_, EPOLL_CTL_DEL, socket, nullptr);
      if (connection.broken)
        close_with_reset(socket);
      else
        ::close(socket);
    }
  }

  void run() {
    std::array<epoll_event, 256> events;
    while (!stopping_) {
      const int n = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), -1);
      for (int i = 0; i < n; ++i) {
        const epoll_event& event = events[static_cast<std::size_t>(i)];
        std::uint64_t ignored = 0;
        if (event.data.ptr == &wake_ || event.data.ptr == &timer_) {
          const int descriptor = *static_cast<int*>(event.data.ptr);
          [[maybe_unused]] const ssize_t got = ::read(descriptor, &ignored, sizeof ignored);
        } else if (event.data.ptr != &listener_) {
          // It does not matter which of its two sockets it is: a socket that is not ready says
          // EAGAIN.
          auto& connection = *static_cast<Connection*>(event.data.ptr);
          for (Direction* way : {&connection.up, &connection.down})
            way->readable = way->writable = true;
        }
      }
      accept_all();
      turn();
    }
  }

  void accept_all() {
    for (;;) {
      const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
      if (client < 0) return;
      const int target = ::socket(target_.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
      const int on = 1;
      for (const int socket : {client, target})
        ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      ::setsockopt(client, SOL_SOCKET, SO_SNDBUF, &kSocketBuffer, sizeof kSocketBuffer);
      ::setsockopt(target, SOL_SOCKET, SO_RCVBUF, &kSocketBuffer, sizeof kSocketBuffer);
      const std::lock_guard lock(mutex_);
      if (::connect(target, reinterpret_cast<const sockaddr*>(&target_), target_size_) != 0 &&
          errno != EINPROGRESS) {
        close_with_reset(client);
        close_with_reset(target);
        continue;
      }
      Connection& connection = connections_.emplace_back();
      connection.client = client;
      connection.target = target;
      connection.up.from = connection.down.to = client;
      connection.up.to = connection.down.from = target;
      // On a real link, the first request would have waited for the round trip of the handshake.
      connection.up.not_before = Clock::now() + 2 * conditions_.delay;
      for (const int socket : {client, target})
        watch(socket, EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET, &connection);
      ++statistics_.connections;
    }
  }

  /// Does everything that is due and sets the timer for the next event.
  void turn() {
    const std::lock_guard lock(mutex_);
    Time now = Clock::now();
    next_ = now + std::chrono::hours(1);
    follow_script(now);
    if (std::exchange(reset_, false))
      for (Connection& connection : connections_) connection.broken = true;
    if (std::exchange(forget_, false))
      for (Connection& connection : connections_) connection.forgotten = true;
    // For fairness, the connection that used the link last is the last in turn.
    const auto taker = std::find_if(connections_.begin(), connections_.end(),
                                    [&](const Connection& c) { return &c == last_taker_; });
    if (taker != connections_.end())
      connections_.splice(connections_.end(), connections_, connections_.begin(), std::next(taker));
    bool again = !conditions_.cut;
    for (int round = 0; again && round < 64; ++round) {
      again = false;
      now = Clock::now();
      for (Connection& connection : connections_) {
        if (connection.broken || connection.forgotten) continue;
        again |= take(connection, connection.up, up_free_at_, now);
        again |= take(connection, connection.down, down_free_at_, now);
        again |= pass_on(connection, connection.up, now, statistics_.up_bytes);
        again |= pass_on(connection, connection.down, now, statistics_.down_bytes);
      }
    }
    if (again) next_ = now;
    std::erase_if(connections_, [&](Connection& connection) {
      const bool over = connection.up.end_passed_on && connection.down.end_passed_on;
      if (!connection.broken && !over) return false;
      close(connection);
      return true;
    });
    statistics_.open = connections_.size();
    set_timer();
  }

  void follow_script(Time now) {
    while (!script_.empty() && script_.front().first <= now) {
      const LinkChange change = script_.front().second;
      script_.pop_front();
      apply(change, conditions_);
      if (change.kind == LinkChange::Kind::reset) reset_ = true;
      if (change.kind == LinkChange::Kind::forget) forget_ = true;
    }
    if (!script_.empty()) next_ = std::min(next_, script_.front().first);
  }

  /// Takes a piece from the sender if it has sent any and the link has room. Returns whether to try
  /// again.
  bool take(Connection& connection, Direction& way, Time& shared_free_at, Time now) {
    if (!way.readable || way.ended) return false;
    Time& free_at = conditions_.rate_each ? way.free_at : shared_free_at;
    const std::uint64_t rate = conditions_.bits_per_second;
    if (rate > 0 && free_at > now + kLinkQueue) {
      next_ = std::min(next_, free_at - kLinkQueue / 2);
      return false;
    }
    const auto carried = std::chrono::duration<double>(conditions_.delay + kLinkQueue).count() / 8 *
                         static_cast<double>(rate > 0 ? rate : kFastest);
    if (way.in_flight >= kMostWaiting + static_cast<std::uint64_t>(carried)) return false;
    // A piece occupies the link for at most a millisecond, so that connections share it evenly.
    const std::size_t most =
        rate == 0 ? kLargestPiece
                  : std::clamp<std::size_t>(rate / 8 / 1000, kSmallestPiece, kLargestPiece);
    buffer_.resize(most);
    const ssize_t got = ::recv(way.from, buffer_.data(), most, 0);
    if (got < 0) {
      if (errno == EAGAIN)
        way.readable = false;
      else if (errno != EINTR)
        connection.broken = true;
      return errno == EINTR;
    }
    const Time leaves = std::max({now, free_at, way.not_before});
    if (got == 0) {
      way.ended = true;
      way.end_due = leaves + conditions_.delay;
      return true;
    }
    const auto size = static_cast<std::size_t>(got);
    Piece piece{leaves + conditions_.delay, {buffer_.data(), buffer_.data() + size}};
    if (rate > 0) {
      const auto takes = std::chrono::nanoseconds(
          static_cast<std::int64_t>(8e9 * static_cast<double>(size) / static_cast<double>(rate)));
      free_at = leaves + takes;
      piece.due += takes;
    }
    if (&way == &connection.down) {
      damage(piece.bytes);
      last_taker_ = &connection;
    }
    way.in_flight += size;
    way.pieces.push_back(std::move(piece));
    return true;
  }

  /// Flips random bits.
  void damage(std::vector<char>& bytes) {
    if (conditions_.corrupt_every == 0) return;
    std::geometric_distribution<std::uint64_t> gap(1.0 /
                                                   static_cast<double>(conditions_.corrupt_every));
    for (std::uint64_t at = gap(random_); at < bytes.size(); at += 1 + gap(random_)) {
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random_() % 8)));
      ++statistics_.flipped_bits;
    }
  }

  /// Passes on the bytes that are due, as far as the receiver accepts them. Returns whether any
  /// moved.
  bool pass_on(Connection& connection, Direction& way, Time now, std::uint64_t& count) {
    bool moved = false;
    const bool down = &way == &connection.down;
    const std::uint64_t last = !down                         ? 0
                               : conditions_.reset_after > 0 ? conditions_.reset_after
                                                             : conditions_.truncate_after;
    while (way.writable && !way.pieces.empty() && way.pieces.front().due <= now) {
      Piece& piece = way.pieces.front();
      std::size_t most = piece.bytes.size() - piece.sent;
      if (conditions_.split > 0) most = std::min(most, conditions_.split);
      if (last > 0) {
        if (way.passed >= last) {
          end_early(connection);
          return false;
        }
        most = std::min<std::size_t>(most, last - way.passed);
      }
      const ssize_t sent =
          ::send(way.to, piece.bytes.data() + piece.sent, most, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0) {
        if (errno == EAGAIN || errno == ENOTCONN)
          way.writable = false;
        else if (errno != EINTR)
          connection.broken = true;
        return moved;
      }
      moved = true;
      const auto n = static_cast<std::size_t>(sent);
      count += n;
      way.passed += n;
      way.in_flight -= n;
      piece.sent += n;
      if (piece.sent == piece.bytes.size()) way.pieces.pop_front();
      // Only one piece in each turn, so that the receiver gets them one by one.
      if (conditions_.split > 0) break;
    }
    if (!way.pieces.empty()) {
      if (way.writable) next_ = std::min(next_, way.pieces.front().due);
    } else if (way.ended && !way.end_passed_on) {
      if (*way.end_due <= now) {
        ::shutdown(way.to, SHUT_WR);
        way.end_passed_on = true;
        moved = true;
      } else {
        next_ = std::min(next_, *way.end_due);
      }
    }
    return moved;
  }

  void end_early(Connection& connection) {
    if (conditions_.reset_after > 0) {
      connection.broken = true;
      return;
    }
    ::shutdown(connection.client, SHUT_WR);
    connection.up.end_passed_on = connection.down.end_passed_on = true;
  }

  void set_timer() {
    const auto wait = std::max<std::int64_t>(
        1, std::chrono::duration_cast<std::chrono::nanoseconds>(next_ - Clock::now()).count());
    itimerspec spec{};
    spec.it_value.tv_sec = wait / 1'000'000'000;
    spec.it_value.tv_nsec = wait % 1'000'000'000;
    ::timerfd_settime(timer_, 0, &spec, nullptr);
  }

  int listener_ = -1, epoll_ = -1, wake_ = -1, timer_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> stopping_{false};

  mutable std::mutex mutex_;
  LinkConditions conditions_;
  sockaddr_storage target_{};
  socklen_t target_size_ = 0;
  bool reset_ = false, forget_ = false;
  std::deque<std::pair<Time, LinkChange>> script_;
  LinkStatistics statistics_;

  // Only the thread uses these.
  std::list<Connection> connections_;
  const Connection* last_taker_ = nullptr;
  Time up_free_at_{}, down_free_at_{}, next_{};
  std::vector<char> buffer_;
  std::mt19937_64 random_;
  std::thread thread_;
};

LinkEmulator::LinkEmulator(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}
LinkEmulator::~LinkEmulator() = default;

Result<std::unique_ptr<LinkEmulator>> LinkEmulator::start(const Options& options) {
  auto loop = std::make_unique<Loop>();
  TRY(loop->open(options));
  return std::unique_ptr<LinkEmulator>(new LinkEmulator(std::move(loop)));
}

std::uint16_t LinkEmulator::port() const { return loop_->port(); }
std::string LinkEmulator::address() const { return fmt::format("127.0.0.1:{}", port()); }
void LinkEmulator::set(const LinkConditions& conditions) { loop_->set(conditions); }
LinkConditions LinkEmulator::conditions() const { return loop_->conditions(); }
Result<void> LinkEmulator::set_target(const std::string& target) {
  return loop_->set_target(target);
}
void LinkEmulator::reset_connections() { loop_->reset_connections(); }
void LinkEmulator::forget_connections() { loop_->forget_connections(); }
Result<void> LinkEmulator::run(const LinkScript& script) { return loop_->start_script(script); }
LinkStatistics LinkEmulator::statistics() const { return loop_->statistics(); }

}  // namespace pointreel
