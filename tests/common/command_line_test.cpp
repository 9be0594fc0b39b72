#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/command_line/command.h"

namespace pointreel::command_line_test {
namespace {

using testing::AllOf;
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
