#pragma once

#include <atomic>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace pointreel {

/// An HTTP server of raw sockets on loopback with one thread per connection. The handler gets the
/// head of each request and the socket, and returns whether the connection is kept open. A body
/// that comes with a Content-Length stands behind the head, after an empty line.
class ScriptedHttpServer {
 public:
  using Handler = std::function<bool(int socket, const std::string& head)>;

  explicit ScriptedHttpServer(Handler handler) : handler_(std::move(handler)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    ::listen(listener_, 16);
    socklen_t size = sizeof address;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    acceptor_ = std::thread([this] {
      for (int client; (client = ::accept(listener_, nullptr, nullptr)) >= 0;) {
        ++connections;
        const std::lock_guard lock(mutex_);
        clients_.push_back(client);
        threads_.emplace_back([this, client] { serve(client); });
      }
    });
  }
  ~ScriptedHttpServer() {
    ::shutdown(listener_, SHUT_RDWR);
    acceptor_.join();
    ::close(listener_);
    for (const int client : clients_) ::shutdown(client, SHUT_RDWR);
    for (std::thread& thread : threads_) thread.join();
    for (const int client : clients_) ::close(client);
  }

  std::string url() const { return fmt::format("http://127.0.0.1:{}", port_); }

  std::atomic<int> connections{0}, requests{0};

 private:
  void serve(int client) {
    std::string buffer;
    char chunk[4096];
    for (;;) {
      std::size_t end;
      while ((end = buffer.find("\r\n\r\n")) == std::string::npos) {
        const ssize_t n = ::recv(client, chunk, sizeof chunk, 0);
        if (n <= 0) return;
        buffer.append(chunk, static_cast<std::size_t>(n));
      }
      ++requests;
      const std::size_t body = length_of_body(buffer.substr(0, end));
      while (buffer.size() < end + 4 + body) {
        const ssize_t n = ::recv(client, chunk, sizeof chunk, 0);
        if (n <= 0) return;
        buffer.append(chunk, static_cast<std::size_t>(n));
      }
      if (!handler_(client, buffer.substr(0, body == 0 ? end : end + 4 + body))) break;
      buffer.erase(0, end + 4 + body);
    }
    ::shutdown(client, SHUT_RDWR);
  }

  static std::size_t length_of_body(const std::string& head) {
    std::size_t length = 0;
    const auto at = head.find("Content-Length: ");
    if (at != std::string::npos) std::sscanf(head.c_str() + at, "Content-Length: %zu", &length);
    return length;
  }

  Handler handler_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::thread acceptor_;
  std::mutex mutex_;
  std::vector<std::thread> threads_;
  std::vector<int> clients_;
};

inline void send_text(int socket, const std::string& text) {
  ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
}

inline void answer(int socket, const std::string& status, const std::string& headers,
                   const std::string& body) {
  send_text(socket, fmt::format("HTTP/1.1 {}\r\nContent-Length: {}\r\n{}\r\n{}", status,
                                body.size(), headers, body));
}

struct RequestedRange {
  std::size_t first, last;
};
inline RequestedRange range_of(const std::string& head) {
  const auto at = head.find("Range: bytes=");
  RequestedRange range{0, 0};
  std::sscanf(head.c_str() + at, "Range: bytes=%zu-%zu", &range.first, &range.last);
  return range;
}

}  // namespace pointreel
