#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace pointreel::bench {

/// A table in Markdown. Every row must have as many cells as the head.
class Table {
 public:
  explicit Table(const std::vector<std::string>& head) {
    row(head);
    row(std::vector<std::string>(head.size(), "---"));
  }
  void row(const std::vector<std::string>& cells) {
    text_ += '|';
    for (const std::string& cell : cells) text_ += ' ' + escaped(cell) + " |";
    text_ += '\n';
  }
  std::string text() const { return text_ + '\n'; }

 private:
  static std::string escaped(std::string cell) {
    for (std::size_t i = 0; (i = cell.find('|', i)) != std::string::npos; i += 2) {
      cell.insert(i, 1, '\\');
    }
    return cell;
  }

  std::string text_;
};

}  // namespace pointreel::bench
