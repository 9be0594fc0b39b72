#include "tests/nginx/nginx.h"

#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/paths.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::array kPlaces = {"/usr/sbin/nginx", "/usr/bin/nginx", "/usr/local/sbin/nginx"};

const char* executable() {
  for (const char* place : kPlaces) {
    if (::access(place, X_OK) == 0) return place;
  }
  return nullptr;
}

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A port that was free a moment ago. nginx cannot choose a free port and report it.
std::uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof(address);
  ::bind(socket, reinterpret_cast<const sockaddr*>(&address), size);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(socket);
  return ntohs(address.sin_port);
}

bool accepts(std::uint16_t port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(port);
  const bool good =
      ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  ::close(socket);
  return good;
}

std::string content(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

bool Nginx::installed() { return executable() != nullptr; }

Result<std::unique_ptr<Nginx>> Nginx::start(
    const fs::path& folder, const std::function<std::string(std::uint16_t port)>& http) {
  const char* program = executable();
  if (program == nullptr) {
    return fail(ErrorCode::not_found, "nginx: is not installed (apt-get install nginx)");
  }
  fs::create_directories(folder);
  const std::string errors = (folder / "error.log").string();
  const std::string file = (folder / "nginx.conf").string();
  std::string fault;
  for (int attempt = 0; attempt < 5; ++attempt) {
    const std::uint16_t port = free_port();
    std::string user = ::geteuid() == 0 ? "user root;\n" : "";
    std::ofstream(file) << user << "daemon off;\nworker_processes auto;\npid nginx.pid;\n"
                        << "error_log error.log warn;\nevents { worker_connections 2048; }\n"
                        << "http {\naccess_log off;\n"
                        << "client_body_temp_path body;\nproxy_temp_path proxy;\n"
                        << "fastcgi_temp_path fastcgi;\nuwsgi_temp_path uwsgi;\n"
                        << "scgi_temp_path scgi;\n"
                        << http(port) << "}\n";
    const pid_t child = ::fork();
    if (child == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGTERM);
      const int log = ::open(errors.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
      ::dup2(log, STDERR_FILENO);
      ::execl(program, program, "-p", folder.c_str(), "-c", file.c_str(), "-e", errors.c_str(),
              static_cast<char*>(nullptr));
      ::_exit(127);
    }
    for (const auto end = Clock::now() + std::chrono::seconds(20); Clock::now() < end;) {
      if (accepts(port)) return std::unique_ptr<Nginx>(new Nginx(child, port));
      if (::waitpid(child, nullptr, WNOHANG) == child) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    fault = content(errors);
    if (fault.find("Address already in use") == std::string::npos) break;
    fs::remove(errors);
  }
  return fail(ErrorCode::io, fmt::format("nginx: {}", fault));
}

Nginx::~Nginx() {
  ::kill(pid_, SIGTERM);
  ::waitpid(pid_, nullptr, 0);
}

std::string nginx_configuration(
    const std::string& name, const std::vector<std::pair<std::string, std::string>>& replacements) {
  std::string text = content(source_folder() / "server/nginx" / name);
  for (const auto& [from, to] : replacements) {
    const auto at = text.find(from);
    if (at == std::string::npos)
      throw std::runtime_error(name + ": does not contain '" + from + "'");
    text.replace(at, from.size(), to);
  }
  return text;
}

}  // namespace pointreel
