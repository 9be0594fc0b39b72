#pragma once

#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

/// A connection to 127.0.0.1 that sends exactly the given bytes, well-formed or not, and never
/// waits longer than its patience.
class RawHttpClient {
 public:
  struct Answer {
    int status = 0;  ///< 0 if the connection or the patience ended before a complete head
    std::map<std::string, std::string> fields;  ///< names in lower case
    std::string body;
    std::string field(const std::string& name) const {
      const auto found = fields.find(name);
      return found == fields.end() ? "" : found->second;
    }
  };

  /// `receive_buffer` > 0 limits what the kernel accepts while the client does not read.
  explicit RawHttpClient(std::uint16_t port, int receive_buffer = 0, int patience_ms = 60'000)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), patience_ms_(patience_ms) {
    if (receive_buffer > 0) {
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof(receive_buffer));
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ =
        ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  virtual ~RawHttpClient() { ::close(socket_); }
  RawHttpClient(const RawHttpClient&) = delete;
  RawHttpClient& operator=(const RawHttpClient&) = delete;

  bool connected() const { return connected_; }

  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = put(bytes.data(), bytes.size());
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  void end_sending() { ::shutdown(socket_, SHUT_WR); }

  /// Waits until there is something to read, and leaves it unread.
  bool has_something() {
    pollfd waiting{socket_, POLLIN, 0};
    return holds_bytes() || ::poll(&waiting, 1, patience_ms_) == 1;
  }

  /// Reads the next response on the connection. `no_body` is set if it answers HEAD.
  Answer read_answer(bool no_body = false) {
    Answer answer;
    std::size_t end = std::string::npos;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
      if (!receive()) return answer;
    }
    const std::string head = buffer_.substr(0, end + 2);
    buffer_.erase(0, end + 4);
    if (head.starts_with("HTTP/1.1 ")) answer.status = std::atoi(head.c_str() + 9);
    for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
      const std::size_t line_end = head.find("\r\n", at);
      const std::string line = head.substr(at, line_end - at);
      const std::size_t colon = line.find(": ");
      if (colon == std::string::npos) {
        ADD_FAILURE() << "this is not a header field: " << line;
        break;
      }
      std::string name = line.substr(0, colon);
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      EXPECT_TRUE(answer.fields.emplace(name, line.substr(colon + 2)).second) << name << " twice";
      at = line_end + 2;
    }
    if (no_body || answer.status == 204 || answer.status == 304) return answer;
    const auto size = static_cast<std::size_t>(
        std::strtoull(answer.field("content-length").c_str(), nullptr, 10));
    while (buffer_.size() < size && receive()) {
    }
    answer.body = buffer_.substr(0, size);
    buffer_.erase(0, answer.body.size());
    return answer;
  }

  Answer request(const std::string& method, const std::string& target,
                 const std::string& fields = "") {
    send(method + " " + target + " HTTP/1.1\r\nHost: localhost\r\n" + fields + "\r\n");
    return read_answer(method == "HEAD");
  }
  Answer get(const std::string& target, const std::string& fields = "") {
    return request("GET", target, fields);
  }

  /// Whether the peer ends the connection, orderly or not, without sending anything more.
  bool ends() {
    const bool more = receive();
    return !more && !timed_out_ && buffer_.empty();
  }

 protected:
  int socket() const { return socket_; }
  virtual ssize_t put(const char* bytes, std::size_t size) {
    return ::send(socket_, bytes, size, MSG_NOSIGNAL);
  }
  virtual ssize_t take(char* bytes, std::size_t size) { return ::recv(socket_, bytes, size, 0); }
  /// Whether bytes were taken from the socket that `take` has not returned yet.
  virtual bool holds_bytes() { return false; }

 private:
  bool receive() {
    pollfd waiting{socket_, POLLIN, 0};
    timed_out_ = !holds_bytes() && ::poll(&waiting, 1, patience_ms_) == 0;
    if (timed_out_) return false;
    char bytes[65536];
    const ssize_t size = take(bytes, sizeof(bytes));
    if (size <= 0) return false;
    buffer_.append(bytes, static_cast<std::size_t>(size));
    return true;
  }

  int socket_;
  int patience_ms_;
  bool connected_ = false, timed_out_ = false;
  std::string buffer_;
};
