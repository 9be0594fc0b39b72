#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/command_line/command.h"

namespace pointreel::command_line_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A program with the commands "make", whose argument is required, "make all" and "send".
class CommandLine : public testing::Test {
 protected:
  CommandLine() {
    program_.require_subcommand(1, 1);
    const cli::Command make = program_.add_subcommand("make", "Make something");
    make.require_subcommand(0, 1);
    make.add_option("THING", thing_, "what to make").required();
    make.add_subcommand("all", "Make everything").add_option("PLACE", thing_, "where").required();
    send_ = program_.add_subcommand("send", "Send something");
    send_.add_option("-i,--input,THING", thing_, "what to send").required().type_name("THING");
    program_.add_common_options();
  }

  std::string fault_of(const std::vector<std::string>& arguments) {
    const auto parsed = program_.parse(arguments);
    return parsed ? "" : parsed.error().message;
  }
  /// What it prints, and returns from main().
  std::pair<std::string, int> printed(const std::vector<const char*>& arguments) {
    testing::internal::CaptureStdout();
    const auto status = program_.parse(static_cast<int>(arguments.size()), arguments.data());
    return {testing::internal::GetCapturedStdout(), status.value_or(-1)};
  }

  std::string thing_;
  cli::Command send_;
  cli::Program program_{"Makes things.", "maker"};
};

TEST_F(CommandLine, names_a_command_that_does_not_exist) {
  EXPECT_EQ(fault_of({"frobnicate"}), "there is no command \"frobnicate\"");
  EXPECT_EQ(fault_of({"frobnicate", "--all"}), "there is no command \"frobnicate\"");
  EXPECT_EQ(fault_of({"--frobnicate"}), "there is no option \"--frobnicate\"");
  EXPECT_EQ(fault_of({}), "a command is missing");
  EXPECT_EQ(fault_of({"make", "it"}), "");
}

TEST_F(CommandLine, lists_options_that_may_stand_without_their_names_as_arguments) {
  const std::string help = send_.help();
  EXPECT_THAT(help, HasSubstr("Arguments:\n  THING                   The same as --input\n"));
  EXPECT_THAT(help, HasSubstr("  -i, --input THING"));
}

/// CLI11 takes brackets around the values of options that take several for a list.
TEST_F(CommandLine, takes_brackets_for_a_part_of_a_value) {
  std::vector<std::string> things, names;
  std::string one;
  const cli::Command keep = program_.add_subcommand("keep", "Keep things");
  keep.add_option("THINGS", things, "what to keep");
  keep.add_option("-n,--name", names, "their names").allow_extra_args(false);
  keep.add_option("-o,--one", one, "where");
  ASSERT_EQ(fault_of({"keep", "[a,b]", "[c]", "\x01[d]", "-n[e]", "--name=[f]", "--name", "[g,h]",
                      "-o", "[i]"}),
            "");
  EXPECT_THAT(things, ElementsAre("[a,b]", "[c]", "\x01[d]"));
  EXPECT_THAT(names, ElementsAre("[e]", "[f]", "[g,h]"));
  EXPECT_EQ(one, "[i]");
  for (const char* given : {"-o-z=[x]", "-oout=[x]", "--one=-z[x]"}) {
    ASSERT_EQ(fault_of({"keep", given}), "");
    EXPECT_EQ(one, std::string(given).substr(given[1] == '-' ? 6 : 2));
  }
  ASSERT_EQ(fault_of({"keep", "--one=", "a"}), "");
  EXPECT_EQ(one, "");
  EXPECT_THAT(things, ElementsAre("a"));
  ASSERT_EQ(fault_of({"keep", "--", "-x[j]", "[k]"}), "");
  EXPECT_THAT(things, ElementsAre("-x[j]", "[k]"));
  EXPECT_EQ(fault_of({"[frobnicate]"}), "there is no command \"[frobnicate]\"");
}

TEST_F(CommandLine, prints_all_help_of_commands_that_have_no_more_than_help) {
  for (const std::vector<const char*>& words : std::vector<std::vector<const char*>>{
           {"maker", "make", "--help-all"}, {"maker", "make", "all", "--help-all"}}) {
    const auto [text, status] = printed(words);
    EXPECT_EQ(status, 0);
    EXPECT_THAT(text, AllOf(HasSubstr("Usage: maker make"), HasSubstr("Arguments:"),
                            Not(HasSubstr("--help-all"))));
  }
}

}  // namespace
}  // namespace pointreel::command_line_test
