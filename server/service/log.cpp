#include "server/service/log.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <future>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/async.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>
#include <unistd.h>

#include "common/threads/run_detached.h"

namespace pointreel {
namespace {

constexpr std::size_t kWaitingLines = 8192;
/// How long the end of the log may take to write the lines that wait.
constexpr std::chrono::milliseconds kLastLines{500};
constexpr std::array<std::string_view, 5> kLevels = {"debug", "info", "warning", "error", "off"};

/// Writes to standard error, but not with stdio: a thread that waits for a reader would hold its
/// lock, for which the end of the process would wait.
class ErrorOutput : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    for (std::size_t at = 0; at < line.size();) {
      const ssize_t put = ::write(STDERR_FILENO, line.data() + at, line.size() - at);
      if (put < 0 && errno != EINTR) return;
      if (put > 0) at += static_cast<std::size_t>(put);
    }
  }
  void flush_() override {}
};

}  // namespace

struct Log::Writer {
  // Not spdlog's global pool, which would outlive the log.
  std::shared_ptr<spdlog::details::thread_pool> pool =
      std::make_shared<spdlog::details::thread_pool>(kWaitingLines, 1);
  std::shared_ptr<spdlog::async_logger> logger =
      std::make_shared<spdlog::async_logger>("pointreel", std::make_shared<ErrorOutput>(), pool,
                                             spdlog::async_overflow_policy::overrun_oldest);
};

Log::Log(Level least) : least_(least) {
  if (least == Level::kOff) return;
  writer_ = std::make_unique<Writer>();
  writer_->logger->set_pattern("%v");
  writer_->logger->flush_on(spdlog::level::trace);
}

Log::~Log() {
  if (!writer_) return;
  // The thread that writes may wait for a pipe that nobody reads. It then ends with the process.
  std::promise<void> ending;
  const std::future<void> ended = ending.get_future();
  run_detached([writer = std::move(writer_), ending = std::move(ending)]() mutable {
    writer.reset();
    ending.set_value();
  });
  ended.wait_for(kLastLines);
}

void Log::write(Level level, std::string_view event, std::initializer_list<Field> fields) {
  if (!writes(level) || !writer_) return;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  writer_->logger->info(write_log_line(
      level, event, fields, std::chrono::duration_cast<std::chrono::microseconds>(now).count()));
}

std::string name(Log::Level level) { return std::string(kLevels[static_cast<std::size_t>(level)]); }

Result<Log::Level> parse_log_level(std::string_view text) {
  for (std::size_t i = 0; i < kLevels.size(); ++i) {
    if (text == kLevels[i]) return static_cast<Log::Level>(i);
  }
  return fail(ErrorCode::argument,
              fmt::format("--log {}: choose debug, info, warning, error or off", text));
}

std::string write_log_line(Log::Level level, std::string_view event,
                           std::initializer_list<Log::Field> fields, std::int64_t unix_us) {
  const std::time_t seconds = unix_us / 1'000'000;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  nlohmann::ordered_json line;
  line["time"] =
      fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900, utc.tm_mon + 1,
                  utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec, unix_us / 1000 % 1000);
  line["level"] = name(level);
  line["event"] = event;
  for (const Log::Field& field : fields) {
    std::visit([&](auto value) { line[std::string(field.name)] = value; }, field.value);
  }
  // Untrusted text may not be UTF-8, but JSON must be.
  // In ASCII, because the log may be watched in a terminal.
  return line.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace pointreel
