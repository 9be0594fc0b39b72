#include "client/record/numbered_path.h"

#include <cctype>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

namespace pointreel {

Result<NumberedPath> NumberedPath::parse(const std::string& pattern) {
  const auto refuse = [&] {
    return fail(ErrorCode::argument,
                fmt::format("\"{}\" must contain exactly one place for the number of the picture, "
                            "such as %04d in out-%04d.png",
                            pattern));
  };
  NumberedPath path;
  bool found = false;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    std::string& text = found ? path.after_ : path.before_;
    if (pattern[i] != '%') {
      text += pattern[i];
      continue;
    }
    if (++i < pattern.size() && pattern[i] == '%') {
      text += '%';
      continue;
    }
    if (found) return refuse();
    if (i < pattern.size() && pattern[i] == '0') path.fill_ = '0';
    for (; i < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[i])); ++i) {
      path.width_ = 10 * path.width_ + static_cast<std::size_t>(pattern[i] - '0');
      if (path.width_ > 20) return refuse();
    }
    if (i >= pattern.size() || pattern[i] != 'd') return refuse();
    found = true;
  }
  if (!found) return refuse();
  return path;
}

std::string NumberedPath::at(std::uint64_t number) const {
  std::string digits = std::to_string(number);
  if (digits.size() < width_) digits.insert(0, width_ - digits.size(), fill_);
  return before_ + digits + after_;
}

std::string NumberedPath::first_free() const {
  std::error_code ignored;
  std::uint64_t number = 1;
  while (std::filesystem::exists(at(number), ignored)) ++number;
  return at(number);
}

}  // namespace pointreel
