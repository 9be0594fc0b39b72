#include "common/process/ffprobe.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/try.h"
#include "common/process/ffmpeg_output.h"

namespace pointreel {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;

/// Hands over each complete line, and leaves the rest.
Result<void> take_lines(std::string& text, const std::function<Result<void>(ProbeLine)>& on_line) {
  std::size_t at = 0;
  for (std::size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    TRY(on_line(ProbeLine(std::string_view(text).substr(at, end - at))));
  text.erase(0, at);
  if (text.size() > kLongestLine) return fail(ErrorCode::limit, "ffprobe prints too long a line");
  return {};
}

}  // namespace

std::string_view ProbeLine::value(std::string_view key) const {
  for (std::size_t at = text_.find('|'); at != text_.npos; at = text_.find('|', at + 1)) {
    std::string_view field = text_.substr(at + 1);
    field = field.substr(0, field.find('|'));
    if (field.starts_with(key) && field.substr(key.size()).starts_with('='))
      return field.substr(key.size() + 1);
  }
  return {};
}

Result<std::string> run_ffprobe(const std::vector<std::string>& arguments,
                                const std::function<Result<void>(ProbeLine)>& on_line) {
  std::vector<std::string> all{"-of", "compact"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  FfmpegOutput output = TRY(FfmpegOutput::start(all, "ffprobe"));
  std::string text;
  std::vector<std::uint8_t> block(1 << 16);
  for (;;) {
    const std::size_t got = TRY(output.read(block));
    text.append(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(got));
    TRY(take_lines(text, on_line));
    if (got < block.size()) break;
  }
  if (const auto fault = output.fault()) return fail(*fault);
  return output.said();
}

}  // namespace pointreel
