#include "common/net/lookup.h"

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>

#include "common/threads/run_detached.h"

namespace pointreel {
namespace {

using boost::asio::ip::tcp;

/// Owned by the caller and by the thread, whichever lives longer.
struct Lookup {
  std::mutex mutex;
  std::condition_variable_any changed;
  bool answered = false;
  std::string problem;
  std::vector<tcp::endpoint> found;
};

void run(Lookup& lookup, const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_flags = AI_ADDRCONFIG;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* all = nullptr;
  const int failed = ::getaddrinfo(host.c_str(), nullptr, &hints, &all);
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(all, &::freeaddrinfo);
  const std::lock_guard lock(lookup.mutex);
  if (failed != 0) lookup.problem = ::gai_strerror(failed);
  for (const addrinfo* each = all; each != nullptr; each = each->ai_next) {
    tcp::endpoint endpoint;
    if (each->ai_addrlen > endpoint.capacity()) continue;
    endpoint.resize(each->ai_addrlen);
    const auto* bytes = reinterpret_cast<const unsigned char*>(each->ai_addr);
    std::copy_n(bytes, each->ai_addrlen, reinterpret_cast<unsigned char*>(endpoint.data()));
    endpoint.port(port);
    lookup.found.push_back(endpoint);
  }
  lookup.answered = true;
  lookup.changed.notify_all();
}

}  // namespace

Result<std::vector<tcp::endpoint>> look_up(const std::string& host, std::uint16_t port,
                                           std::chrono::milliseconds timeout,
                                           const std::stop_token& stop) {
  boost::system::error_code no_address;
  const auto address = boost::asio::ip::make_address(host, no_address);
  if (!no_address) return std::vector{tcp::endpoint(address, port)};
  const auto lookup = std::make_shared<Lookup>();
  run_detached([lookup, host, port] { run(*lookup, host, port); });
  std::unique_lock lock(lookup->mutex);
  const bool answered =
      lookup->changed.wait_for(lock, stop, timeout, [&] { return lookup->answered; });
  if (!answered && stop.stop_requested()) return fail(ErrorCode::cancelled, "cancelled");
  if (!answered)
    return fail(ErrorCode::io, fmt::format("no answer to the lookup of the name within {:g} s",
                                           static_cast<double>(timeout.count()) / 1000));
  if (lookup->found.empty())
    return fail(ErrorCode::io, "the name is not known: " + lookup->problem);
  return std::move(lookup->found);
}

}  // namespace pointreel
