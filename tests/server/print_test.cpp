#include "common/process/print.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "codec/core/json_fields.h"
#include "codec/core/reel_rules.h"
#include "common/base/words.h"
#include "server/service/log.h"
#include "tests/terminal_text.h"

namespace pointreel::print_test {
namespace {

TEST(Visible, leaves_text_that_may_be_printed_as_it_is) {
  for (const char* text : {"", "frame 3: a\\b", "Grüße, 世界, עברית, 🙂"})
    EXPECT_EQ(visible(text), text);
}

TEST(Visible, shows_what_would_move_the_terminal_or_turn_the_writing_around) {
  EXPECT_EQ(visible("a\x1b]0;title\x07 b"), "a\\x1b]0;title\\x07 b");
  EXPECT_EQ(visible("two\r\nlines\tand \x7f"), "two\\r\\nlines\\tand \\x7f");
  EXPECT_EQ(visible("\xc2\x9b"
                    "31m"),
            "\\u009b31m");
  EXPECT_EQ(visible("gnp.\xe2\x80\xaexe"), "gnp.\\u202exe");
  EXPECT_EQ(visible("\xe2\x81\xa6x\xe2\x81\xa9"), "\\u2066x\\u2069");
  EXPECT_EQ(visible("\xe2\x80\xa8"), "\\u2028");
  EXPECT_EQ(visible(std::string_view("\0", 1)), "\\x00");
}

TEST(Visible, shows_bytes_that_are_not_utf8) {
  EXPECT_EQ(visible("\x9b"
                    "31m"),
            "\\x9b31m");
  EXPECT_EQ(visible("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(visible("\xc0\x9b"), "\\xc0\\x9b") << "too long";
  EXPECT_EQ(visible("\xe0\x82\x9b"), "\\xe0\\x82\\x9b") << "too long";
  EXPECT_EQ(visible("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(visible("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond Unicode";
  EXPECT_EQ(visible("\xe2\x80"), "\\xe2\\x80") << "cut off";
}

TEST(Visible, makes_any_bytes_harmless) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20'000; ++trial) {
    const std::string text = foreign_text(random);
    const std::string shown = visible(text);
    EXPECT_EQ(harm_to_terminal(shown), "") << shown;
    EXPECT_EQ(shown.find('\n'), std::string::npos);
    EXPECT_EQ(visible(shown), shown);
    EXPECT_LE(shown.size(), 6 * text.size());
  }
}

TEST(Title, is_text_that_may_be_shown_as_it_is) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 20'000; ++trial) {
    const std::string text = foreign_text(random).substr(0, kMaxTitle);
    EXPECT_EQ(is_title(text), visible(text) == text) << visible(text);
  }
  for (const char* text : {"", "frame 3: a\\b", "Grüße, 世界, עברית, 🙂"})
    EXPECT_TRUE(is_title(text));
  ReelHead head;
  head.codec = "draco";
  head.name = "gnp.\xe2\x80\xaexe";
  EXPECT_FALSE(check_head(head));
  head.name =
      "\xc2\x9b"
      "31m";
  EXPECT_FALSE(check_head(head));
}

TEST(FormatVisible, breaks_lines_only_where_the_format_says_so) {
  EXPECT_EQ(format_visible("{}: {} and {}\n", std::string("a\nb"), 3, "c\x1b"),
            "a\\nb: 3 and c\\x1b\n");
}

TEST(Log, a_line_is_harmless_whatever_its_fields_hold) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 2'000; ++trial) {
    const std::string text = foreign_text(random);
    const std::string line = write_log_line(Log::Level::kInfo, "request", {{"target", text}}, 0);
    EXPECT_EQ(harm_to_terminal(line), "") << line;
  }
}

TEST(Words, count_one_thing_in_the_singular) {
  EXPECT_EQ(counted(0, "frame"), "0 frames");
  EXPECT_EQ(counted(1, "frame"), "1 frame");
  EXPECT_EQ(counted(2, "frame"), "2 frames");
  EXPECT_EQ(counted(2, "box", "boxes"), "2 boxes");
  EXPECT_EQ(span_text(10, 10), "10");
  EXPECT_EQ(span_text(8, 10), "8 to 10");
}

TEST(Words, numbers_have_no_exponent_where_they_can_be_read_without) {
  EXPECT_EQ(number_text(5'411'930), "5411930");
  EXPECT_EQ(number_text(5'411'934.4, 4), "5412000");
  EXPECT_EQ(number_text(1e9), "1000000000");
  EXPECT_EQ(number_text(-0.25), "-0.25");
  EXPECT_EQ(number_text(0.000123456789), "0.000123457");
  EXPECT_EQ(number_text(99.99996, 4), "100");
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(1e-9), "1e-09");
  EXPECT_EQ(number_text(1e300), "1e+300");
}

}  // namespace
}  // namespace pointreel::print_test
