#include "tests/e2e/play.h"

#include <gtest/gtest.h>

#include "tests/e2e/process.h"

namespace pointreel::e2e {

nlohmann::json play_until(const std::vector<std::string>& arguments,
                          const std::function<bool(const nlohmann::json&)>& enough) {
  nlohmann::json report(nlohmann::json::value_t::discarded);
  Outcome played;
  for (int seconds = 1; seconds <= 32; seconds *= 2) {
    std::vector<std::string> all = {"play"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.insert(all.end(), {"--duration", std::to_string(seconds), "--json", "-"});
    played = run("pointreel", all);
    report = nlohmann::json::parse(played.out, nullptr, false);
    // Without any frame in so short a time there is an error instead of a report.
    if (!report.is_discarded() && enough(report)) break;
  }
  EXPECT_EQ(played.exit_code, 0) << played.err;
  return report;
}

}  // namespace pointreel::e2e
