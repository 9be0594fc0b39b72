#include "client/source/http_client.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include <curl/curl.h>
#include <fmt/format.h>

namespace pointreel {

struct HttpClient::Connection {
  Connection() : handle(curl_easy_init()) {}
  ~Connection() { curl_easy_cleanup(handle); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  CURL* const handle;
};

/// Size 0: the whole file. At most `limit` bytes may come.
struct HttpClient::Wanted {
  std::uint64_t offset = 0, size = 0, total = 0, limit = 0;

  bool is_range() const { return size > 0; }
  bool is_whole_file() const { return size == total; }
};

struct HttpClient::Answer {
  Result<Bytes> body;
  bool may_pass = false;  ///< a failure that is worth another attempt
};

namespace {

/// Bodies of error pages are read so far, to keep the connection, and thrown away.
constexpr std::uint64_t kMaxErrorPage = 64 * 1024;

struct Transfer {
  CURL* handle = nullptr;
  const std::atomic<bool>* cancelled = nullptr;
  std::uint64_t limit = 0;
  Bytes body;
  std::uint64_t discarded = 0;
  bool too_long = false;
  std::string content_range;  ///< of the last response; redirects have earlier ones
};

long status_of(CURL* handle) {
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  return status;
}

std::size_t on_body(char* data, std::size_t, std::size_t size, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  const long status = status_of(transfer.handle);
  if (status != 200 && status != 206) {
    transfer.discarded += size;
    return transfer.discarded <= kMaxErrorPage ? size : 0;
  }
  if (transfer.body.size() + size > transfer.limit) {
    transfer.too_long = true;
    return 0;
  }
  transfer.body.insert(transfer.body.end(), data, data + size);
  return size;
}

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

std::size_t on_header(char* data, std::size_t, std::size_t size, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  std::string_view line(data, size);
  if (line.starts_with("HTTP/")) transfer.content_range.clear();
  constexpr std::string_view kName = "content-range:";
  const bool matches =
      line.size() > kName.size() &&
      std::equal(kName.begin(), kName.end(), line.begin(), [](char name, char given) {
        return name == static_cast<char>(std::tolower(static_cast<unsigned char>(given)));
      });
  if (matches) {
    line.remove_prefix(kName.size());
    while (!line.empty() && is_space(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
    transfer.content_range = line;
  }
  return size;
}

int on_progress(void* user, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return static_cast<Transfer*>(user)->cancelled->load() ? 1 : 0;
}

bool is_loopback(std::string_view url) {
  const std::string_view host = url.substr(url.find("://") + 3);
  return host.starts_with("127.") || host.starts_with("localhost") || host.starts_with("[::1]");
}

void set_options(CURL* handle, const std::string& url, const SourceOptions& options,
                 Transfer& transfer) {
  curl_easy_reset(handle);
  curl_easy_setopt(handle, CURLOPT_URL, url.c_str());
  curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(handle, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(handle, CURLOPT_FOLLOWLOCATION, 1L);
  curl_easy_setopt(handle, CURLOPT_MAXREDIRS, 4L);
  curl_easy_setopt(handle, CURLOPT_USERAGENT, "pointreel");
  curl_easy_setopt(handle, CURLOPT_BUFFERSIZE, 256L * 1024);
  curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT_MS,
                   static_cast<long>(options.connect_timeout.count()));
  curl_easy_setopt(handle, CURLOPT_TIMEOUT_MS, static_cast<long>(options.transfer_timeout.count()));
  // A proxy that the environment names is for the world outside.
  if (is_loopback(url)) curl_easy_setopt(handle, CURLOPT_PROXY, "");
  curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, on_body);
  curl_easy_setopt(handle, CURLOPT_WRITEDATA, &transfer);
  curl_easy_setopt(handle, CURLOPT_HEADERFUNCTION, on_header);
  curl_easy_setopt(handle, CURLOPT_HEADERDATA, &transfer);
  curl_easy_setopt(handle, CURLOPT_NOPROGRESS, 0L);
  curl_easy_setopt(handle, CURLOPT_XFERINFOFUNCTION, on_progress);
  curl_easy_setopt(handle, CURLOPT_XFERINFODATA, &transfer);
}

double seconds(std::chrono::milliseconds time) { return static_cast<double>(time.count()) / 1000; }

std::string transfer_error(CURLcode code, const Transfer& transfer, const SourceOptions& options) {
  switch (code) {
    case CURLE_URL_MALFORMAT:
      return "is no valid address";
    case CURLE_COULDNT_RESOLVE_HOST:
      return "the host's name is not known; check the address and the network";
    case CURLE_COULDNT_CONNECT:
      return "nothing answers there; check host and port, and that the server runs";
    case CURLE_OPERATION_TIMEDOUT: {
      double connected = 0.0;
      curl_easy_getinfo(transfer.handle, CURLINFO_CONNECT_TIME, &connected);
      if (connected <= 0.0)
        return fmt::format("no connection within {:g} s; check host and port",
                           seconds(std::min(options.connect_timeout, options.transfer_timeout)));
      return fmt::format("not complete after {:g} s ({} bytes came)",
                         seconds(options.transfer_timeout), transfer.body.size());
    }
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
      return fmt::format("the connection broke after {} bytes", transfer.body.size());
    default:
      return curl_easy_strerror(code);
  }
}

bool transfer_error_may_pass(CURLcode code) {
  return code == CURLE_COULDNT_CONNECT || code == CURLE_COULDNT_RESOLVE_HOST ||
         code == CURLE_OPERATION_TIMEDOUT || code == CURLE_PARTIAL_FILE ||
         code == CURLE_GOT_NOTHING || code == CURLE_RECV_ERROR || code == CURLE_SEND_ERROR;
}

const char* explain(long status) {
  switch (status) {
    case 403:
      return " (forbidden)";
    case 404:
      return " (not found)";
    case 416:
      return " (the file is shorter than its manifest says)";
    default:
      return "";
  }
}

}  // namespace

HttpClient::HttpClient(const SourceOptions& options) : options_(options) {
  [[maybe_unused]] static const CURLcode global = curl_global_init(CURL_GLOBAL_DEFAULT);
}

HttpClient::~HttpClient() = default;

Result<Bytes> HttpClient::get(const std::string& url, std::uint64_t max_bytes) {
  return get_with_retries(url, Wanted{0, 0, 0, max_bytes});
}

Result<Bytes> HttpClient::get_range(const std::string& url, std::uint64_t offset,
                                    std::uint64_t size, std::uint64_t total) {
  return get_with_retries(url, Wanted{offset, size, total, size});
}

void HttpClient::cancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  cancelled_changed_.notify_all();
}

Result<Bytes> HttpClient::get_with_retries(const std::string& url, const Wanted& wanted) {
  std::unique_ptr<Connection> connection;
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      connection = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!connection) connection = std::make_unique<Connection>();
  if (connection->handle == nullptr) return fail("libcurl cannot be started");

  std::chrono::milliseconds pause = options_.first_backoff;
  for (int i = 1;; ++i) {
    Answer answer = attempt(*connection, url, wanted);
    std::unique_lock lock(mutex_);
    if (answer.body || !answer.may_pass || i >= options_.attempts || cancelled_) {
      idle_.push_back(std::move(connection));
      if (cancelled_) return fail("cancelled");
      if (!answer.body && answer.may_pass && i > 1)
        return fail(fmt::format("{} ({} attempts)", answer.body.error().message, i));
      return std::move(answer.body);
    }
    cancelled_changed_.wait_for(lock, pause, [&] { return cancelled_.load(); });
    pause *= 2;
  }
}

HttpClient::Answer HttpClient::attempt(Connection& connection, const std::string& url,
                                       const Wanted& wanted) const {
  if (cancelled_) return {fail("cancelled"), false};
  Transfer transfer;
  transfer.handle = connection.handle;
  transfer.cancelled = &cancelled_;
  transfer.limit = wanted.limit;
  set_options(connection.handle, url, options_, transfer);
  std::string range;
  if (wanted.is_range()) {
    range = fmt::format("{}-{}", wanted.offset, wanted.offset + wanted.size - 1);
    curl_easy_setopt(connection.handle, CURLOPT_RANGE, range.c_str());
  }

  const CURLcode code = curl_easy_perform(connection.handle);
  const long status = status_of(connection.handle);
  if (status >= 400)
    return {fail(fmt::format("the server answers {}{}", status, explain(status))),
            status >= 500 || status == 408 || status == 429};
  if (wanted.is_range() && !wanted.is_whole_file() && status == 200)
    return {fail("the server sends whole files instead of ranges; it must support Range requests"),
            false};
  if (transfer.too_long)
    return {fail(fmt::format("the server sends more than the {} bytes expected", wanted.limit)),
            false};
  if (code != CURLE_OK)
    return {fail(transfer_error(code, transfer, options_)), transfer_error_may_pass(code)};
  if (status != 200 && !(wanted.is_range() && status == 206))
    return {fail(fmt::format("the server answers {} where {} is expected", status,
                             wanted.is_range() ? 206 : 200)),
            false};
  if (status == 206 && transfer.content_range != fmt::format("bytes {}/{}", range, wanted.total) &&
      transfer.content_range != fmt::format("bytes {}/*", range))
    return {fail(fmt::format("asked for bytes {} of {}, but the server sends \"{}\": the package "
                             "has changed, or the server is at fault",
                             range, wanted.total, transfer.content_range)),
            false};
  if (wanted.is_range() && transfer.body.size() != wanted.size)
    return {fail(fmt::format("{} bytes came instead of {}", transfer.body.size(), wanted.size)),
            true};
  return {std::move(transfer.body), false};
}

}  // namespace pointreel
