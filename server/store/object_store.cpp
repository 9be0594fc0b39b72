#include "server/store/object_store.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <mutex>
#include <random>
#include <utility>

#include <curl/curl.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/base/backoff.h"
#include "common/base/try.h"
#include "common/http/aws_signature.h"
#include "common/http/http_failure.h"
#include "common/http/http_request.h"
#include "common/http/store_error.h"

namespace pointreel {
namespace {

using Kind = HttpFailure::Kind;

/// What a store says about a failure is in the first bytes of its answer.
constexpr std::size_t kMaxRefusal = 2048;
/// A connection on which less moves than this, per second for so many seconds, is given up. The
/// store's answer may take its time.
constexpr long kLeastRate = 256, kPatience = 30;
/// Contents up to this size are sent at once: asking first whether the store wants them pays only
/// for larger ones.
constexpr std::uint64_t kSentUnasked = std::uint64_t{1} << 20;
/// The name of the header that holds the checksum.
constexpr const char* kChecksumHeader = "x-amz-meta-xxh3";

struct Md5 {
  std::array<unsigned char, 16> bytes{};

  std::string hex() const {
    std::string text;
    for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
    return text;
  }
  std::string base64() const {
    std::array<unsigned char, 25> text{};
    EVP_EncodeBlock(text.data(), bytes.data(), static_cast<int>(bytes.size()));
    return reinterpret_cast<const char*>(text.data());
  }
};

Result<Md5> md5_of(const ObjectContent& content) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        &EVP_MD_CTX_free);
  if (!context || EVP_DigestInit_ex(context.get(), EVP_md5(), nullptr) != 1)
    return fail("this machine's OpenSSL has no MD5, which uploads need");
  std::string block(std::size_t{1} << 20, '\0');
  for (std::uint64_t offset = 0; offset < content.bytes();) {
    const std::size_t size = content.read(offset, block.data(), block.size());
    if (size == 0) return fail(ErrorCode::io, "cannot be read to its end");
    EVP_DigestUpdate(context.get(), block.data(), size);
    offset += size;
  }
  Md5 md5;
  EVP_DigestFinal_ex(context.get(), md5.bytes.data(), nullptr);
  return md5;
}

/// A header of the handle's newest answer; none if it has none.
std::optional<std::string> header_of(CURL* handle, const char* name) {
  curl_header* header = nullptr;
  if (curl_easy_header(handle, name, 0, CURLH_HEADER, -1, &header) != CURLHE_OK)
    return std::nullopt;
  return header->value;
}

std::optional<std::uint64_t> checksum_in(const std::optional<std::string>& text) {
  std::uint64_t value = 0;
  if (!text || text->size() != 16) return std::nullopt;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value, 16);
  if (error != std::errc() || end != text->data() + text->size()) return std::nullopt;
  return value;
}

/// The MD5 of an object as its entity tag tells it; none where the store makes tags of other
/// things, as it does for what it encrypts.
std::optional<std::string> md5_in(CURL* handle) {
  if (header_of(handle, "x-amz-server-side-encryption") ||
      header_of(handle, "x-amz-server-side-encryption-customer-algorithm"))
    return std::nullopt;
  std::string tag = header_of(handle, "ETag").value_or("");
  if (tag.size() >= 2 && tag.front() == '"' && tag.back() == '"')
    tag = tag.substr(1, tag.size() - 2);
  const bool hex = tag.size() == 32 && tag.find_first_not_of("0123456789abcdef") == tag.npos;
  return hex ? std::optional(tag) : std::nullopt;
}

Error cancelled() { return {"interrupted", ErrorCode::cancelled}; }

/// False if `stop` was asked to stop meanwhile.
bool wait_for(std::chrono::steady_clock::duration time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace

ObjectContent::ObjectContent(std::string_view text) : text_(text), bytes_(text.size()) {}

Result<ObjectContent> ObjectContent::open(const std::filesystem::path& file) {
  ObjectContent content;
  content.file_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status{};
  if (content.file_ < 0 || ::fstat(content.file_, &status) != 0 || !S_ISREG(status.st_mode))
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be read: {}", file.string(),
                            content.file_ < 0 ? std::strerror(errno) : "it is not a file"));
  content.bytes_ = static_cast<std::uint64_t>(status.st_size);
  return content;
}

ObjectContent::ObjectContent(ObjectContent&& other) noexcept
    : file_(std::exchange(other.file_, -1)), text_(other.text_), bytes_(other.bytes_) {}

ObjectContent::~ObjectContent() {
  if (file_ >= 0) ::close(file_);
}

std::size_t ObjectContent::read(std::uint64_t offset, char* to, std::size_t size) const {
  if (offset >= bytes_) return 0;
  size = static_cast<std::size_t>(std::min<std::uint64_t>(size, bytes_ - offset));
  if (file_ < 0) return text_.copy(to, size, static_cast<std::size_t>(offset));
  for (;;) {
    const ssize_t got = ::pread(file_, to, size, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    return got < 0 ? 0 : static_cast<std::size_t>(got);
  }
}

Result<std::string> ObjectContent::md5() const { return TRY(md5_of(*this)).hex(); }

/// One attempt of a request.
class ObjectStore::Request {
 public:
  Request(ObjectStore& store, const std::string& url, std::uint64_t max_bytes)
      : handle(store.handle_), options_(store.options_), limit_(max_bytes) {
    prepare_request(handle, url, options_);
    set(CURLOPT_WRITEFUNCTION, &Request::on_body);
    set(CURLOPT_WRITEDATA, static_cast<void*>(this));
    set(CURLOPT_LOW_SPEED_LIMIT, kLeastRate);
    set(CURLOPT_LOW_SPEED_TIME, kPatience);
    set(CURLOPT_NOPROGRESS, 0L);
    set(CURLOPT_XFERINFOFUNCTION, &Request::on_progress);
    set(CURLOPT_XFERINFODATA, static_cast<void*>(this));
  }
  ~Request() {
    set(CURLOPT_HTTPHEADER, static_cast<curl_slist*>(nullptr));
    curl_slist_free_all(headers_);
  }
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;

  template <class Value>
  void set(CURLoption option, Value value) {
    curl_easy_setopt(handle, option, value);
  }
  void add(const std::string& header) { headers_ = curl_slist_append(headers_, header.c_str()); }
  void send(const ObjectContent& content) {
    content_ = &content;
    set(CURLOPT_UPLOAD, 1L);
    set(CURLOPT_UPLOAD_BUFFERSIZE, 512L * 1024);
    set(CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(content.bytes()));
    set(CURLOPT_READFUNCTION, &Request::on_read);
    set(CURLOPT_READDATA, static_cast<void*>(this));
    set(CURLOPT_SEEKFUNCTION, &Request::on_seek);
    set(CURLOPT_SEEKDATA, static_cast<void*>(this));
  }

  /// Nothing if the store answers with 2xx.
  std::optional<HttpFailure> perform(const AwsAccess& access) {
    headers_ = sign(handle, headers_, access);
    set(CURLOPT_HTTPHEADER, headers_);
    std::array<char, CURL_ERROR_SIZE> said{};
    set(CURLOPT_ERRORBUFFER, said.data());
    const CURLcode code = curl_easy_perform(handle);
    set(CURLOPT_ERRORBUFFER, static_cast<char*>(nullptr));
    if (options_.stop.stop_requested()) return HttpFailure{Kind::final, cancelled()};
    const long status = status_of(handle);
    if (status >= 400) return failure_of_status(status, body);
    if (status >= 300) return failure_of_store_redirect(status, body);
    if (unreadable_)
      return http_failure(Kind::final, "the file that is sent cannot be read to its end",
                          "check the disk");
    if (too_long_)
      return http_failure(Kind::doubtful,
                          fmt::format("the store sends more than the {} bytes expected", limit_));
    curl_off_t connected = 0;
    curl_easy_getinfo(handle, CURLINFO_PRETRANSFER_TIME_T, &connected);
    if (code == CURLE_OPERATION_TIMEDOUT && connected > 0)
      return http_failure(Kind::passing, fmt::format("nothing moved for {} s", kPatience),
                          "check the link");
    const char* url = "";
    curl_easy_getinfo(handle, CURLINFO_EFFECTIVE_URL, &url);
    if (code != CURLE_OK) return failure_of_transfer(code, url, options_, body.size(), said.data());
    if (status < 200)
      return http_failure(Kind::doubtful, fmt::format("the store answers {}", status));
    return std::nullopt;
  }

  void* const handle;
  std::string body;  ///< of the answer: whole with 2xx, and else its beginning

 private:
  static std::size_t on_body(char* data, std::size_t, std::size_t size, void* user) {
    auto& self = *static_cast<Request*>(user);
    const bool good = status_of(self.handle) < 300;
    if (!good) {
      self.body.append(data, std::min(size, kMaxRefusal - std::min(kMaxRefusal, self.body.size())));
      return self.body.size() < kMaxRefusal ? size : 0;
    }
    self.too_long_ = size > self.limit_ - self.body.size();
    if (self.too_long_) return 0;
    self.body.append(data, size);
    return size;
  }
  static std::size_t on_read(char* to, std::size_t, std::size_t size, void* user) {
    auto& self = *static_cast<Request*>(user);
    const std::size_t got = self.content_->read(self.sent_, to, size);
    self.unreadable_ = got == 0 && self.sent_ < self.content_->bytes();
    self.sent_ += got;
    return self.unreadable_ ? CURL_READFUNC_ABORT : got;
  }
  static int on_seek(void* user, curl_off_t offset, int origin) {
    if (origin != SEEK_SET) return CURL_SEEKFUNC_CANTSEEK;
    static_cast<Request*>(user)->sent_ = static_cast<std::uint64_t>(offset);
    return CURL_SEEKFUNC_OK;
  }
  static int on_progress(void* user, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    return static_cast<Request*>(user)->options_.stop.stop_requested() ? 1 : 0;
  }

  const HttpOptions& options_;
  const std::uint64_t limit_;
  curl_slist* headers_ = nullptr;
  const ObjectContent* content_ = nullptr;
  std::uint64_t sent_ = 0;
  bool too_long_ = false, unreadable_ = false;
};

ObjectStore::ObjectStore(const HttpOptions& options, AwsAccess access)
    : options_(options), access_(std::move(access)), handle_((start_http(), curl_easy_init())) {
  // TLS may write to a connection that the store has closed, which would end the process.
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
}

ObjectStore::~ObjectStore() { curl_easy_cleanup(handle_); }

/// Calls `attempt`, which returns a failure or nothing, until it succeeds or is given up.
template <class Attempt>
Result<void> ObjectStore::perform(const std::string& url, const Attempt& attempt) {
  if (handle_ == nullptr) return fail(ErrorCode::limit, "not enough memory");
  Backoff<std::chrono::milliseconds> pause(options_.first_backoff, options_.max_backoff);
  std::minstd_rand random{std::random_device{}()};
  bool doubted = false;
  for (int attempts = 1;; ++attempts) {
    const std::optional<HttpFailure> failure = attempt();
    if (!failure) return {};
    if (failure->error.code == ErrorCode::cancelled) return tl::unexpected(failure->error);
    const bool again = attempts < options_.open_attempts &&
                       (failure->kind == Kind::passing ||
                        (failure->kind == Kind::doubtful && !std::exchange(doubted, true)));
    if (!again) return tl::unexpected(failure_line(url, *failure, attempts));
    if (!wait_for(jittered(pause.wait(), random), options_.stop))
      return tl::unexpected(cancelled());
    pause.failed();
  }
}

Result<std::optional<StoredObject>> ObjectStore::look(const std::string& url) {
  std::optional<StoredObject> found;
  TRY(perform(url, [&]() -> std::optional<HttpFailure> {
    Request request(*this, url, 0);
    request.set(CURLOPT_NOBODY, 1L);
    const auto failure = request.perform(access_);
    // An answer to this kind of request has no body that would tell why.
    const long status = status_of(request.handle);
    if (status == 404 || status == 403) return std::nullopt;
    if (failure) return failure;
    curl_off_t bytes = -1;
    curl_easy_getinfo(request.handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &bytes);
    if (bytes >= 0)
      found = StoredObject{static_cast<std::uint64_t>(bytes),
                           checksum_in(header_of(request.handle, kChecksumHeader)),
                           md5_in(request.handle)};
    return std::nullopt;
  }));
  return found;
}

Result<std::optional<std::string>> ObjectStore::get(const std::string& url,
                                                    std::uint64_t max_bytes) {
  std::optional<std::string> found;
  TRY(perform(url, [&]() -> std::optional<HttpFailure> {
    Request request(*this, url, max_bytes);
    const auto failure = request.perform(access_);
    const long status = status_of(request.handle);
    const std::string code = status >= 400 ? store_error_code(request.body) : std::string();
    // Without the right to list a bucket, what is not there looks forbidden.
    if ((status == 404 && code != "NoSuchBucket") || (status == 403 && code == "AccessDenied"))
      return std::nullopt;
    if (failure) return failure;
    found = std::move(request.body);
    return std::nullopt;
  }));
  return found;
}

Result<void> ObjectStore::put(const std::string& url, const ObjectContent& content,
                              const ObjectHeaders& headers) {
  const auto md5 = md5_of(content);
  if (!md5) return fail_at(url, md5.error());
  return perform(url, [&]() -> std::optional<HttpFailure> {
    Request request(*this, url, kMaxRefusal);
    request.add("Content-Type: " + headers.content_type);
    request.add("Cache-Control: " + headers.cache_control);
    request.add("Content-MD5: " + md5->base64());
    request.add(fmt::format("{}: {:016x}", kChecksumHeader, headers.checksum));
    // A header "Expect:" would be signed, though it is not sent, by libcurl before 8.3.
    if (content.bytes() <= kSentUnasked) request.set(CURLOPT_EXPECT_100_TIMEOUT_MS, 1L);
    request.send(content);
    if (const auto failure = request.perform(access_)) return failure;
    if (const auto stored = md5_in(request.handle); stored && *stored != md5->hex())
      return http_failure(Kind::doubtful, "the store has stored other bytes than were sent",
                          "try again, and check what lies between this machine and the store");
    return std::nullopt;
  });
}

}  // namespace pointreel
