#include "common/command_line/command_table.h"

#include <fmt/format.h>

namespace pointreel::cli {

std::string CommandEntry::words() const {
  return fmt::format("{}", fmt::join(path.begin() + 1, path.end(), " "));
}

std::string summary_of(const std::string& description) {
  const std::string line = description.substr(0, description.find('\n'));
  std::string sentence = line.substr(0, line.find(". "));
  if (sentence.ends_with('.')) sentence.pop_back();
  return sentence;
}

}  // namespace pointreel::cli
