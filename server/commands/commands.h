#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/command_line/command.h"
#include "common/process/print.h"
#include "pointreel/error.h"

/// The subcommands of pointreel-server.
namespace pointreel {

struct PageFile;

/// The exit status of every subcommand.
inline constexpr int kExitOk = 0, kExitFailed = 1, kExitUsage = 2;

/// Each adds subcommands to the program. When one of them has run, `exit_code` holds its result.
void add_pack_command(cli::Command app, int& exit_code);
void add_audio_command(cli::Command app, int& exit_code);
void add_edit_commands(cli::Command app, int& exit_code);     ///< cut and join
void add_inspect_commands(cli::Command app, int& exit_code);  ///< info, verify and unpack
void add_upload_command(cli::Command app, int& exit_code);
void add_publish_command(cli::Command app, int& exit_code);
/// `command_line`: the arguments of the program, which are read again on SIGHUP. `page`: the page
/// that browsers get; its memory must stay valid.
void add_serve_command(cli::Command app, int& exit_code, std::vector<std::string> command_line,
                       std::span<const PageFile> page);
void add_page_command(cli::Command app, int& exit_code, std::span<const PageFile> page);

/// Prints `pointreel-server: message` to standard error, as one line.
inline void print_error(const std::string& message) { print_error("pointreel-server", message); }

/// Prints the error and returns the exit code.
inline int failed(const Error& error) {
  print_error(error.message);
  return kExitFailed;
}
/// The same where a package cannot be opened: what is not one is wrong usage.
inline int failed_to_open(const Error& error) {
  print_error(error.message);
  return error.code == ErrorCode::argument || error.code == ErrorCode::not_found ? kExitUsage
                                                                                 : kExitFailed;
}

}  // namespace pointreel
