#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "pointreel/error.h"

namespace spdlog {
class logger;
}

namespace pointreel {

/// Structured lines, one JSON object each, on standard error:
///   {"time":"2026-01-31T12:00:00.123Z","level":"warning","event":"...",...}
/// Any thread may write, and none waits for the reader: if lines are written faster than they are
/// read, the oldest are dropped. The destructor waits for the reader, but only half a second.
class Log {
 public:
  enum class Level { kDebug, kInfo, kWarning, kError, kOff };
  struct Field {
    std::string_view name;
    std::variant<std::string_view, std::int64_t, double, bool> value;
  };

  /// Writes lines of the level `least` and above.
  explicit Log(Level least);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  bool writes(Level level) const { return level >= least_; }
  /// `fields` may hold untrusted text, which is escaped.
  void write(Level level, std::string_view event, std::initializer_list<Field> fields = {});

 private:
  Level least_;
  struct Writer;
  std::unique_ptr<Writer> writer_;
};

/// "debug", "info", "warning", "error" or "off".
std::string name(Log::Level level);
Result<Log::Level> parse_log_level(std::string_view text);

/// The line of one event, without a line feed. `unix_us` is the Unix time in microseconds.
std::string write_log_line(Log::Level level, std::string_view event,
                           std::initializer_list<Log::Field> fields, std::int64_t unix_us);

}  // namespace pointreel
