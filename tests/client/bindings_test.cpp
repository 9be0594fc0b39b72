#include "client/ui/bindings.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::bindings_test {
namespace {

TEST(Bindings, use_no_key_twice) {
  std::set<std::string_view> keys;
  for (const Binding& binding : bindings())
    EXPECT_TRUE(keys.insert(binding.key).second) << binding.key;
}

TEST(Bindings, give_every_action_a_key) {
  std::set<Action> actions;
  for (const Binding& binding : bindings()) actions.insert(binding.action);
  EXPECT_EQ(actions.size(), static_cast<std::size_t>(Action::quit) + 1);
}

TEST(Bindings, follow_those_of_mpv) {
  EXPECT_EQ(action_of("SPACE"), Action::toggle_play);
  EXPECT_EQ(action_of("LEFT"), Action::seek_back);
  EXPECT_EQ(action_of("."), Action::step_forward);
  EXPECT_EQ(action_of("]"), Action::faster);
  EXPECT_EQ(action_of("p"), Action::toggle_play);
  EXPECT_EQ(action_of("UP"), Action::seek_forward_far);
  EXPECT_EQ(action_of("o"), Action::tell_time);
  EXPECT_EQ(action_of("Shift+LEFT"), Action::seek_back_little);
  EXPECT_EQ(action_of("l"), Action::mark_loop);
  EXPECT_EQ(action_of("L"), Action::toggle_loop);
  EXPECT_EQ(action_of("{"), Action::half_speed);
  EXPECT_EQ(action_of("q"), Action::quit);
  EXPECT_EQ(action_of("ESC"), Action::leave);
}

TEST(Bindings, map_unknown_keys_to_no_action) {
  EXPECT_EQ(action_of("x"), std::nullopt);
  EXPECT_EQ(action_of(""), std::nullopt);
}

TEST(Bindings, are_all_listed_in_the_help) {
  const std::string help = bindings_help();
  for (const Binding& binding : bindings()) {
    EXPECT_THAT(help, testing::HasSubstr(std::string(binding.key)));
    EXPECT_THAT(help, testing::HasSubstr(std::string(binding.help)));
  }
}

TEST(Bindings, share_one_line_of_the_help_if_they_do_the_same) {
  const auto keys_of = [](Action action) -> std::vector<std::string_view> {
    for (const Binding& binding : bindings()) {
      if (binding.action != action) continue;
      for (const HelpLine& line : help_lines())
        if (line.help == binding.help) return line.keys;
    }
    return {};
  };
  EXPECT_THAT(keys_of(Action::toggle_play), testing::ElementsAre("SPACE", "p"));
  EXPECT_THAT(keys_of(Action::step_forward), testing::ElementsAre(",", "."));
  EXPECT_THAT(keys_of(Action::quit), testing::ElementsAre("q"));
  EXPECT_THAT(bindings_help(), testing::HasSubstr("  SPACE  p                play or pause\n"));
}

}  // namespace
}  // namespace pointreel::bindings_test
