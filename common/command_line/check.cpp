#include "common/command_line/check.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace pointreel::cli {

Check not_empty(const std::string& what) {
  return {[what](const std::string& text) {
    return text.empty() ? "is empty; give " + what + ", or leave it out" : std::string();
  }};
}

Check number_option(const std::string& what, std::function<bool(double)> good) {
  return {[what, good = std::move(good)](const std::string& text) {
    const std::optional<double> value = number_of(text);
    return value && good(*value) ? std::string() : fmt::format("{} is not {}", text, what);
  }};
}

Check number_within(double least, double most) {
  return number_option(fmt::format("a number from {:.10g} to {:.10g}", least, most),
                       [=](double value) { return value >= least && value <= most; });
}

Check positive_number() {
  return number_option("a number above 0",
                       [](double value) { return value > 0.0 && std::isfinite(value); });
}

Check whole_number() {
  return {[](const std::string& text) {
    std::uint64_t value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && stop == end) return std::string();
    return fmt::format("{} is not a whole number from 0 to {}", text,
                       std::numeric_limits<std::uint64_t>::max());
  }};
}

}  // namespace pointreel::cli
