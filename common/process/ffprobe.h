#pragma once

#include <charconv>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/error.h"

namespace pointreel {

/// A line of what ffprobe prints with `-of compact`, such as "stream|index=0|codec_name=ffv1".
class ProbeLine {
 public:
  explicit ProbeLine(std::string_view text) : text_(text) {}

  bool is(std::string_view kind) const { return text_.starts_with(kind); }
  /// Empty if there is none.
  std::string_view value(std::string_view key) const;
  /// 0 if there is none.
  template <class Number>
  Number number(std::string_view key) const {
    const std::string_view text = value(key);
    Number number{};
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
  }

 private:
  std::string_view text_;
};

/// Runs ffprobe with these arguments and `-of compact`, hands over each line, and returns what it
/// said on its standard error (Ffmpeg::said). Errors: `not_found` if it is not installed; `io` if
/// it cannot be run or stops printing; `invalid`, and the first line that it said, if it fails;
/// those of `on_line`.
Result<std::string> run_ffprobe(const std::vector<std::string>& arguments,
                                const std::function<Result<void>(ProbeLine)>& on_line);

}  // namespace pointreel
