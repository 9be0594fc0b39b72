#include "client/options/option_table.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "client/options/option_text.h"

namespace pointreel::option_table_test {
namespace {

TEST(OptionTable, every_name_is_there_once) {
  std::set<std::string_view> names;
  for (const Option& option : option_table()) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    EXPECT_EQ(&find_option(option.name), &option);
    if (option.old_name.empty()) continue;
    EXPECT_TRUE(names.insert(option.old_name).second) << option.old_name;
  }
}

TEST(OptionTable, names_in_the_settings_file_do_not_change) {
  std::set<std::string_view> names;
  for (const Option& option : option_table())
    names.insert(option.old_name.empty() ? option.name : option.old_name);
  EXPECT_EQ(names,
            (std::set<std::string_view>{
                "window",           "loop",       "mode",   "renderer",        "instancing",
                "splatting",        "fill_holes", "refine", "smooth_outlines", "delta",
                "visibility_scale", "edl",        "color",  "point_size",      "adaptive_points",
                "shading_scale",    "lighting",   "light",  "roughness",       "pixel_size",
                "drafts",           "background", "floor",  "drawing_panel",   "statistics_panel",
                "ui_scale",         "volume",     "mute"}));
}

TEST(OptionTable, defaults_and_both_ends_of_ranges_are_accepted_and_what_lies_beyond_is_not) {
  for (const Option& option : option_table()) {
    const auto* number = std::get_if<Option::Number>(&option.value);
    if (number == nullptr) continue;
    EXPECT_TRUE(number->range.contains(number->get({}))) << option.name;
    EXPECT_TRUE(number->range.contains(number->slider.min)) << option.name;
    EXPECT_TRUE(number->range.contains(number->slider.max)) << option.name;
    Settings settings;
    for (const double end : {number->range.min, number->range.max}) {
      EXPECT_TRUE(set_from_text(option, std::to_string(end), settings)) << option.name;
      EXPECT_NEAR(number->get(settings), end, 1e-6) << option.name;
    }
    const Settings before = settings;
    for (const double beyond : {number->range.min - 0.1, number->range.max + 0.1})
      EXPECT_FALSE(set_from_text(option, std::to_string(beyond), settings)) << option.name;
    for (const char* text : {"", "nan", "x", "1,2", "1 "})
      EXPECT_FALSE(set_from_text(option, text, settings)) << option.name << " " << text;
    EXPECT_EQ(settings, before);
  }
}

TEST(OptionTable, every_choice_can_be_made_by_its_name) {
  for (const Option& option : option_table()) {
    const auto* choice = std::get_if<Option::Choice>(&option.value);
    if (choice == nullptr) continue;
    EXPECT_TRUE(choice->labels.empty() || choice->labels.size() == choice->names.size());
    for (const char* name : choice->names) {
      Settings settings;
      ASSERT_TRUE(set_from_text(option, name, settings)) << name;
      EXPECT_EQ(value_text(option, settings), name);
      Settings copy;
      copy_value(option, settings, copy);
      EXPECT_EQ(copy, settings);
    }
  }
}

TEST(OptionTable, colours_are_read_with_and_without_a_number_sign) {
  EXPECT_EQ(color_text(*parse_color("#1c1f24")), "#1c1f24");
  EXPECT_EQ(*parse_color("ff8000"), *parse_color("#FF8000"));
  for (const char* text : {"", "#", "red", "#12345", "#1234567", "#12345g", "#-12345", "##12345"})
    EXPECT_FALSE(parse_color(text)) << text;
}

}  // namespace
}  // namespace pointreel::option_table_test
