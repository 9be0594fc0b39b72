#include "tests/bench/program.h"

#include <fmt/format.h>

namespace pointreel::bench {

Result<e2e::Outcome> run_program(const std::string& program,
                                 const std::vector<std::string>& arguments) {
  constexpr int kSeconds = 600;
  const e2e::Outcome outcome = e2e::run(program, arguments, kSeconds);
  if (outcome.exit_code == 0) return outcome;
  return fail(ErrorCode::io,
              fmt::format("{} {}: exit code {}: {}", program, arguments.front(), outcome.exit_code,
                          outcome.err.substr(0, outcome.err.find('\n'))));
}

}  // namespace pointreel::bench
