#include "tests/bench/output.h"

#include <cstdio>
#include <fstream>

#include <fmt/format.h>

#include "common/process/print.h"

namespace pointreel::bench {

std::string grouped(std::size_t n) {
  if (n < 1000) return std::to_string(n);
  return fmt::format("{},{:03}", grouped(n / 1000), n % 1000);
}

std::string default_folder(const std::string& benchmark) { return "build/bench/" + benchmark; }

Result<void> write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) return fail(ErrorCode::io, file.string() + ": cannot be written");
  return {};
}

Result<void> write_json(const std::string& file, const nlohmann::json& report) {
  const std::string text =
      report.dump(2, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
  if (file != "-") return write_text(file, text);
  if (!print_lines(text)) {
    return fail(ErrorCode::io, "standard output: cannot be written");
  }
  return {};
}

}  // namespace pointreel::bench
