#include "tests/load/crowd.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace pointreel {
namespace {

constexpr std::size_t kPiece = 4096;

}  // namespace

CrowdMember::~CrowdMember() {
  if (socket_ >= 0) ::close(socket_);
}

Result<void> CrowdMember::connect(const Url& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url.port);
  if (::inet_pton(AF_INET, url.host.c_str(), &address.sin_addr) != 1)
    return fail(ErrorCode::argument,
                url.place() + ": give an IPv4 address in digits, such as 127.0.0.1");
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0 ||
      ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return fail(ErrorCode::io, fmt::format("{}: {}", url.place(), std::strerror(errno)));
  const int on = 1;
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ::fcntl(socket_, F_SETFL, O_NONBLOCK);
  return {};
}

LoadClock::time_point CrowdMember::on_due(LoadClock::time_point now) {
  return now + std::chrono::hours(1);
}

void CrowdMember::break_off() {
  broken_ = true;
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
}

void CrowdMember::send(std::string_view text) {
  if (broken_) return;
  if (::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
    break_off();
}

void CrowdMember::skip(std::uint64_t size) {
  const auto here = std::min<std::uint64_t>(size, buffer().size());
  take(here);
  skip_ = size - here;
}

void CrowdMember::read() {
  while (!broken_) {
    if (skip_ > 0) {
      // MSG_TRUNC discards the bytes without copying them.
      const ssize_t n = ::recv(socket_, nullptr, skip_, MSG_TRUNC);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) return;
      if (n <= 0) return break_off();
      bytes_ += static_cast<std::uint64_t>(n);
      skip_ -= static_cast<std::uint64_t>(n);
      if (skip_ == 0 && !on_skipped()) return break_off();
      continue;
    }
    buffer_.erase(0, taken_);
    taken_ = 0;
    const std::size_t before = buffer_.size();
    buffer_.resize(before + kPiece);
    const ssize_t n = ::recv(socket_, buffer_.data() + before, kPiece, 0);
    buffer_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return;
    if (n <= 0 || !use(static_cast<std::size_t>(n))) return break_off();
  }
}

bool CrowdMember::use(std::size_t arrived) {
  bytes_ += arrived;
  // Stop when on_data takes nothing more, because the rest has yet to arrive or must be skipped.
  for (std::size_t before = taken_ + 1; before != taken_ && skip_ == 0;) {
    before = taken_;
    if (!on_data()) return false;
  }
  return true;
}

void run_crowd(const std::vector<std::unique_ptr<CrowdMember>>& members,
               LoadClock::time_point first_due, LoadClock::time_point end,
               const std::function<void()>& begin_measuring, LoadClock::time_point measured_from) {
  const int epoll = ::epoll_create1(EPOLL_CLOEXEC);
  using Due = std::pair<LoadClock::time_point, std::size_t>;
  std::priority_queue<Due, std::vector<Due>, std::greater<>> due;
  for (std::size_t i = 0; i < members.size(); ++i) {
    epoll_event event{};
    event.events = EPOLLIN | EPOLLRDHUP;
    event.data.u64 = i;
    ::epoll_ctl(epoll, EPOLL_CTL_ADD, members[i]->socket(), &event);
    due.emplace(first_due, i);
  }
  bool measuring = false;
  std::array<epoll_event, 128> events;
  for (;;) {
    const auto now = LoadClock::now();
    if (now >= end) break;
    if (!measuring && now >= measured_from) {
      measuring = true;
      begin_measuring();
    }
    while (!due.empty() && due.top().first <= now) {
      const std::size_t i = due.top().second;
      due.pop();
      if (!members[i]->broken()) due.emplace(members[i]->on_due(now), i);
    }
    auto next = measuring ? end : std::min(end, measured_from);
    if (!due.empty()) next = std::min(next, due.top().first);
    const auto wait = std::chrono::duration_cast<std::chrono::nanoseconds>(next - LoadClock::now());
    const auto nanoseconds = std::max<std::int64_t>(wait.count(), 0);
    const timespec timeout{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
    const int n =
        ::epoll_pwait2(epoll, events.data(), static_cast<int>(events.size()), &timeout, nullptr);
    for (int i = 0; i < n; ++i) members[events[static_cast<std::size_t>(i)].data.u64]->read();
  }
  ::close(epoll);
}

}  // namespace pointreel
