#include "codec/rate/quality_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include <gtest/gtest.h>

namespace pointreel::quality_search_test {
namespace {

constexpr std::uint64_t kPoints = 1'000'000;

/// Bytes by quality, and what the search makes of them.
using Bytes = std::function<double(int quality)>;

QualitySearch searched(double budget, int asked, const Bytes& bytes) {
  QualitySearch search(budget, asked, kPoints);
  while (!search.accepts(bytes(search.quality()))) {
    EXPECT_LT(search.tries(), 12) << "the search does not end";
    if (search.tries() >= 12) break;
  }
  return search;
}

/// Steeper above quality 50, as real video is.
double usual(int quality) {
  return 8e3 * std::exp(0.02 * quality + 0.02 * std::max(0, quality - 50));
}

TEST(QualitySearch, fits_the_budget_and_uses_most_of_it_in_few_encodes) {
  for (const double factor : {0.3, 1.0, 3.0}) {  // of what the first guess expects
    const auto bytes = [factor](int quality) { return factor * usual(quality); };
    for (const int best : {10, 30, 50, 70, 95}) {
      const double budget = 1.01 * bytes(best);
      const QualitySearch search = searched(budget, 100, bytes);
      EXPECT_TRUE(search.fits());
      EXPECT_LE(search.quality(), best);
      EXPECT_GE(bytes(search.quality()), 0.8 * budget);
      EXPECT_LE(search.tries(), 5);
    }
  }
}

TEST(QualitySearch, is_no_finer_than_asked) {
  const QualitySearch search = searched(1e9, 40, usual);
  EXPECT_TRUE(search.fits());
  EXPECT_EQ(search.quality(), 40);
  EXPECT_EQ(search.tries(), 1);
}

TEST(QualitySearch, ends_at_the_coarsest_if_nothing_fits) {
  const QualitySearch search = searched(10.0, 100, usual);
  EXPECT_FALSE(search.fits());
  EXPECT_EQ(search.quality(), 1);
}

TEST(QualitySearch, ends_where_bytes_jump_or_do_not_grow_with_the_quality) {
  const QualitySearch jump = searched(1e4, 100, [](int q) { return q < 33 ? 1e3 : 1e5; });
  EXPECT_TRUE(jump.fits());
  EXPECT_LT(jump.quality(), 33);
  EXPECT_TRUE(searched(1e4, 100, [](int) { return 1e4; }).fits());
  EXPECT_FALSE(searched(1e4, 100, [](int) { return 1e5; }).fits());
  const QualitySearch falls = searched(1e4, 100, [](int q) { return q > 60 ? 9e3 : 2e4; });
  EXPECT_LE(falls.tries(), 12);
  EXPECT_TRUE(searched(0.0, 1, [](int) { return 0.0; }).fits());
}

}  // namespace
}  // namespace pointreel::quality_search_test
