#include "client/ui/time_text.h"

#include <fmt/format.h>

namespace pointreel {

std::string format_time(std::uint64_t us) {
  const std::uint64_t ms = us / 1000, seconds = ms / 1000, minutes = seconds / 60;
  const std::string rest = fmt::format("{:02}:{:02}.{:03}", minutes % 60, seconds % 60, ms % 1000);
  return minutes < 60 ? rest : fmt::format("{}:{}", minutes / 60, rest);
}

}  // namespace pointreel
