#include "common/http/http_client.h"

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <list>
#include <mutex>
#include <random>
#include <thread>
#include <utility>

#include <curl/curl.h>
#include <fmt/format.h>

#include "common/base/backoff.h"
#include "common/base/try.h"
#include "common/http/http_request.h"
#include "common/http/http_transfer.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using std::chrono::milliseconds;

/// The most requests under way at the same time, and the most connections that are kept.
constexpr std::size_t kMaxActive = 8;
/// An answer that nobody waits for any more is read to its end if no more than this is missing, and
/// for no longer than this: that keeps its connection, and making another takes a round trip.
constexpr std::uint64_t kWorthReading = 32 * 1024;
constexpr auto kReadingTime = milliseconds(500);
/// For this long after a failure, connections that have been idle since before it are not trusted.
constexpr auto kSuspicion = std::chrono::seconds(120);

Error cancelled() { return {"cancelled", ErrorCode::cancelled}; }

std::string host_of(const std::string& url) {
  const auto parsed = parse_url(url);
  return parsed ? parsed->place() : url;
}

}  // namespace

/// What the loop consists of.
namespace http_client {

/// The smallest value of the last five to ten seconds.
class RecentMinimum {
 public:
  void add(Clock::duration value, Time now) {
    if (now - begun_ > std::chrono::seconds(5)) {
      before_ = now - begun_ > std::chrono::seconds(10) ? Clock::duration::max() : current_;
      current_ = Clock::duration::max();
      begun_ = now;
    }
    current_ = std::min(current_, value);
  }
  Clock::duration get() const { return std::min(before_, current_); }

 private:
  Clock::duration before_ = Clock::duration::max(), current_ = Clock::duration::max();
  Time begun_{};
};

/// The requests that one call waits for.
struct Batch {
  std::vector<HttpWanted> wanted;
  int attempts = 0;  ///< the most for each request; 0: without end
  // The loop's mutex guards what follows.
  bool stopped = false, done = false;
  std::optional<Error> error;
  std::size_t missing = 0;
  std::vector<Bytes> bodies;
  std::string tag;         ///< of the first request's answer
  bool unchanged = false;  ///< the first request's file still has its tag
};

struct Job {
  Job(std::shared_ptr<Batch> of, std::size_t number, const HttpOptions& options,
      const std::optional<AwsAccess>& access)
      : batch(std::move(of)),
        index(number),
        transfer(batch->wanted[number], options, access),
        pause(options.first_backoff, options.max_backoff),
        stall_limit(options.stall_timeout, 4 * options.stall_timeout) {}

  std::shared_ptr<Batch> batch;  ///< null: nobody waits for it
  std::size_t index;
  HttpTransfer transfer;
  CURL* active = nullptr;
  int attempts = 0;
  Backoff<milliseconds> pause;        ///< before the next attempt
  Backoff<milliseconds> stall_limit;  ///< without a byte; longer for a server that stays silent
  bool doubted = false;               ///< its answer made no sense once
  Time not_before{}, read_until{};
  std::string trouble;
};

}  // namespace http_client

using namespace http_client;

class HttpClient::Loop : HttpTransfer::Listener {
 public:
  Loop(const HttpOptions& options, std::optional<AwsAccess> access)
      : options_(options), access_(std::move(access)) {
    start_http();
    multi_ = curl_multi_init();
    curl_multi_setopt(multi_, CURLMOPT_MAXCONNECTS, static_cast<long>(kMaxActive));
    thread_ = std::thread([this] { run(); });
  }
  ~Loop() override {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = ending_ = true;
    }
    wake();
    thread_.join();
    curl_multi_cleanup(multi_);
  }

  Result<void> get(const std::shared_ptr<Batch>& batch, const std::stop_token& stop) {
    const std::stop_callback on_stop(stop, [&] {
      {
        const std::lock_guard lock(mutex_);
        batch->stopped = true;
      }
      done_.notify_all();
      wake();
    });
    batch->missing = batch->wanted.size();
    batch->bodies.resize(batch->wanted.size());
    std::unique_lock lock(mutex_);
    if (batch->wanted.empty()) return {};
    inbox_.push_back(batch);
    wake();
    done_.wait(lock, [&] { return batch->done || batch->stopped || cancelled_; });
    if (batch->done && !batch->error) return {};
    // Whichever it was, the loop need not go on with the rest.
    batch->stopped = true;
    wake();
    return tl::unexpected(batch->error ? *batch->error : cancelled());
  }

  void cancel() {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    done_.notify_all();
    wake();
  }

  std::stop_token stop() const { return options_.stop; }
  int open_attempts() const { return std::max(1, options_.open_attempts); }
  int fetch_attempts() const { return options_.fetch_attempts; }

  std::optional<std::string> trouble() const {
    const std::lock_guard lock(mutex_);
    if (trouble_.empty()) return std::nullopt;
    return trouble_;
  }

  LinkUse link_use() const {
    const std::lock_guard lock(mutex_);
    return use_;
  }

 private:
  void wake() { curl_multi_wakeup(multi_); }

  void run() {
    // TLS may write to a connection that the peer has closed, which would end the process.
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    ::pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
    Time before = Clock::now();
    for (;;) {
      if (!take_orders()) break;
      const Time now = Clock::now();
      if (std::any_of(jobs_.begin(), jobs_.end(), [](const auto& job) { return job->active; }))
        busy_ += now - before;
      before = now;
      begin_due(now);
      int running = 0;
      curl_multi_perform(multi_, &running);
      finish_ended();
      give_up_slow(Clock::now());
      publish();
      const auto wait = std::chrono::ceil<milliseconds>(next_deadline() - Clock::now());
      curl_multi_poll(multi_, nullptr, 0,
                      static_cast<int>(std::clamp<std::int64_t>(wait.count(), 0, 60'000)), nullptr);
    }
    for (const auto& job : jobs_) end_attempt(*job);
    jobs_.clear();
  }

  /// Takes new requests in and drops those that nobody waits for. False if the loop is to end.
  bool take_orders() {
    const std::lock_guard lock(mutex_);
    if (ending_) return false;
    for (const auto& batch : inbox_)
      for (std::size_t i = 0; i < batch->wanted.size(); ++i) {
        jobs_.push_back(std::make_unique<Job>(batch, i, options_, access_));
        jobs_.back()->transfer.listener = this;
      }
    inbox_.clear();
    const Time now = Clock::now();
    std::erase_if(jobs_, [&](const std::unique_ptr<Job>& job) {
      if (job->batch == nullptr || !(job->batch->stopped || job->batch->error || cancelled_))
        return false;
      if (!cancelled_ && worth_reading(*job)) {
        job->batch = nullptr;
        job->read_until = now + kReadingTime;
        return false;
      }
      end_attempt(*job);
      return true;
    });
    return true;
  }

  bool worth_reading(const Job& job) const {
    const auto unwanted = std::count_if(jobs_.begin(), jobs_.end(),
                                        [](const auto& other) { return other->batch == nullptr; });
    return job.active != nullptr && job.transfer.missing() <= kWorthReading &&
           unwanted < static_cast<std::ptrdiff_t>(kMaxActive);
  }

  void begin_due(Time now) {
    auto active =
        static_cast<std::size_t>(std::count_if(jobs_.begin(), jobs_.end(), [](const auto& job) {
          return job->active != nullptr && job->batch;
        }));
    for (const auto& job : jobs_) {
      if (active >= kMaxActive) return;
      if (job->active != nullptr || job->not_before > now) continue;
      // Connections that have been idle since before the newest failure may be dead by now.
      const auto since = std::chrono::floor<std::chrono::seconds>(now - newest_failure_);
      const auto max_idle = newest_failure_ == Time{} || since > kSuspicion
                                ? kSuspicion
                                : std::max(std::chrono::seconds(1), since);
      job->active = job->transfer.begin(job->attempts > 0, max_idle);
      ++job->attempts;
      ++active;
      if (job->active != nullptr) curl_multi_add_handle(multi_, job->active);
    }
  }

  void end_attempt(Job& job) {
    if (job.active == nullptr) return;
    curl_multi_remove_handle(multi_, job.active);
    job.active = nullptr;
  }

  void finish_ended() {
    int left = 0;
    while (const CURLMsg* message = curl_multi_info_read(multi_, &left)) {
      if (message->msg != CURLMSG_DONE) continue;
      CURL* const handle = message->easy_handle;
      const int code = message->data.result;  // removing the handle invalidates the message
      const auto job = std::find_if(jobs_.begin(), jobs_.end(),
                                    [&](const auto& each) { return each->active == handle; });
      if (job == jobs_.end()) continue;
      const auto failure = (*job)->transfer.finish(code);
      end_attempt(**job);
      if ((*job)->batch == nullptr || settle(**job, failure)) jobs_.erase(job);
    }
  }

  void give_up_slow(Time now) {
    std::erase_if(jobs_, [&](const std::unique_ptr<Job>& job) {
      if (job->active == nullptr) return false;
      if (job->batch == nullptr) {
        if (now < job->read_until) return false;
        end_attempt(*job);
        return true;
      }
      const auto deadline = stall_deadline(*job);
      const bool stalled = deadline && now >= *deadline;
      if (!stalled && now < job->transfer.due()) return false;
      const HttpFailure failure =
          stalled ? job->transfer.stalled(job->stall_limit.wait()) : job->transfer.too_slow(now);
      if (job->transfer.newest_byte())
        job->stall_limit.succeeded();
      else
        job->stall_limit.failed();
      end_attempt(*job);
      return settle(*job, failure);
    });
  }

  /// None while there is no connection, which has a time limit of its own.
  std::optional<Time> stall_deadline(const Job& job) const {
    const auto sent = job.transfer.sent_at();
    if (!sent) return std::nullopt;
    return std::max(*sent, job.transfer.newest_byte().value_or(Time{})) + job.stall_limit.wait();
  }

  /// Deals with the end of an attempt. True if the job is over.
  bool settle(Job& job, const std::optional<HttpFailure>& failure) {
    Batch& batch = *job.batch;
    if (!failure) {
      const std::lock_guard lock(mutex_);
      publish_use();
      batch.bodies[job.index] = job.transfer.take_body();
      if (job.index == 0) {
        batch.tag = job.transfer.tag();
        batch.unchanged = job.transfer.unchanged();
      }
      if (--batch.missing == 0 && !batch.error) batch.done = true;
      done_.notify_all();
      return true;
    }
    const bool passing = failure->kind == HttpFailure::Kind::passing;
    const bool again = passing ? batch.attempts == 0 || job.attempts < batch.attempts
                               : failure->kind == HttpFailure::Kind::doubtful && !job.doubted;
    if (!again) {
      const std::lock_guard lock(mutex_);
      if (!batch.error)
        batch.error = failure_line(job.transfer.wanted().url, *failure, job.attempts);
      batch.done = true;
      done_.notify_all();
      return true;
    }
    job.doubted = job.doubted || !passing;
    newest_failure_ = Clock::now();
    job.not_before = newest_failure_ + jittered(job.pause.wait(), random_);
    job.pause.failed();
    job.trouble = fmt::format("{}: {}; trying again", host_of(job.transfer.wanted().url),
                              with_advice(*failure));
    return false;
  }

  Time next_deadline() const {
    Time next = Clock::now() + std::chrono::seconds(60);
    for (const auto& job : jobs_) {
      if (job->active == nullptr)
        next = std::min(next, job->not_before);
      else if (job->batch == nullptr)
        next = std::min(next, job->read_until);
      else if (const auto deadline = stall_deadline(*job))
        next = std::min({next, *deadline, job->transfer.due()});
      else
        // No event tells when the connection has been made.
        next = std::min(next, Clock::now() + options_.stall_timeout / 2);
    }
    return next;
  }

  void publish() {
    std::string trouble;
    for (const auto& job : jobs_)
      if (job->batch != nullptr && !job->trouble.empty()) trouble = job->trouble;
    const bool changed = trouble != trouble_;
    {
      const std::lock_guard lock(mutex_);
      trouble_ = trouble;
      publish_use();
    }
    if (changed && options_.on_trouble)
      options_.on_trouble(trouble.empty() ? std::nullopt : std::optional(trouble));
  }

  /// Call this with the mutex held.
  void publish_use() {
    use_.busy = std::chrono::duration_cast<std::chrono::microseconds>(busy_);
    use_.receiving = std::chrono::duration_cast<std::chrono::microseconds>(receiving_);
    use_.bytes = bytes_;
    if (round_trip_.get() != Clock::duration::max())
      use_.round_trip = std::chrono::duration_cast<std::chrono::microseconds>(round_trip_.get());
  }

  /// Between two bytes the link was busy, unless it had nothing to carry yet: an answer begins a
  /// round trip after its request.
  void on_bytes(const HttpTransfer& transfer, Time now, std::size_t size, bool first) override {
    const Time sent = transfer.sent_at().value_or(now);
    if (first) round_trip_.add(now - sent, now);
    bytes_ += size;
    const Time since = std::max(newest_byte_, sent + round_trip_.get());
    if (now > since) receiving_ += now - since;
    newest_byte_ = now;
  }

  const HttpOptions options_;
  const std::optional<AwsAccess> access_;
  CURLM* multi_ = nullptr;

  mutable std::mutex mutex_;
  std::condition_variable done_;
  std::vector<std::shared_ptr<Batch>> inbox_;
  bool cancelled_ = false, ending_ = false;
  std::string trouble_;  ///< only the thread writes it
  LinkUse use_;

  // Only the thread uses what follows.
  std::list<std::unique_ptr<Job>> jobs_;
  std::minstd_rand random_{std::random_device{}()};
  Time newest_failure_{}, newest_byte_{};
  RecentMinimum round_trip_;
  Clock::duration busy_{}, receiving_{};
  std::uint64_t bytes_ = 0;
  std::thread thread_;
};

HttpClient::HttpClient(const HttpOptions& options, std::optional<AwsAccess> access)
    : loop_(std::make_unique<Loop>(options, std::move(access))) {}

HttpClient::~HttpClient() = default;

Result<Bytes> HttpClient::get(const std::string& url, std::uint64_t max_bytes) {
  const auto batch = std::make_shared<Batch>();
  batch->wanted.push_back({.url = url, .limit = max_bytes});
  batch->attempts = loop_->open_attempts();
  TRY(loop_->get(batch, loop_->stop()));
  return std::move(batch->bodies[0]);
}

Result<std::optional<Bytes>> HttpClient::get_if_changed(const std::string& url,
                                                        std::uint64_t max_bytes, std::string& tag,
                                                        const std::stop_token& stop) {
  const auto batch = std::make_shared<Batch>();
  batch->wanted.push_back({.url = url, .limit = max_bytes, .tag = tag});
  TRY(loop_->get(batch, stop));
  if (batch->unchanged) return std::nullopt;
  tag = batch->tag;
  return std::move(batch->bodies[0]);
}

Result<std::vector<Bytes>> HttpClient::get_ranges(std::span<const Range> ranges,
                                                  const std::stop_token& stop, bool fresh) {
  const auto batch = std::make_shared<Batch>();
  for (const Range& range : ranges)
    batch->wanted.push_back({.url = range.url,
                             .offset = range.offset,
                             .size = range.size,
                             .total = range.total,
                             .fresh = fresh});
  batch->attempts = loop_->fetch_attempts();
  TRY(loop_->get(batch, stop));
  return std::move(batch->bodies);
}

void HttpClient::cancel() { loop_->cancel(); }
std::optional<std::string> HttpClient::trouble() const { return loop_->trouble(); }
LinkUse HttpClient::link_use() const { return loop_->link_use(); }

}  // namespace pointreel
