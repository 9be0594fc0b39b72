#include "server/commands/parts_commands.h"

#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/base/try.h"
#include "common/base/words.h"
#include "common/process/print.h"
#include "common/process/progress.h"
#include "common/process/run_program.h"
#include "common/process/stop_signal.h"
#include "server/commands/commands.h"
#include "server/commands/pack_arguments.h"
#include "server/commands/pack_progress.h"
#include "server/parts/join_parts.h"
#include "server/parts/pack_part.h"
#include "server/parts/plan.h"
#include "server/parts/slurm.h"

namespace pointreel {
namespace {

/// "3/7".
std::optional<PartOf> parse_part(const std::string& text) {
  PartOf part;
  const char* end = text.data() + text.size();
  const auto index = std::from_chars(text.data(), end, part.index);
  if (index.ec != std::errc() || index.ptr == end || *index.ptr != '/') return std::nullopt;
  const auto count = std::from_chars(index.ptr + 1, end, part.count);
  if (count.ec != std::errc() || count.ptr != end) return std::nullopt;
  if (part.index < 1 || part.index > part.count) return std::nullopt;
  return part;
}

int run_plan(const PackArguments& arguments) {
  const Result<PackOptions> options = arguments.options_with_paths(true);
  if (!options) {
    print_error(options.error().message);
    return kExitUsage;
  }
  const StopSignal stop;
  const Result<MadePlan> made = make_plan(*options, arguments.command_line(), stop.token());
  if (!made) return failed(made.error());
  for (const std::string& line : made->warnings) print_error("warning: " + line);
  print("{}: {} in {}\n", parts_folder(options->output).string(), counted(made->frames, "frame"),
        counted(made->segments, "segment"));
  for (const std::string& guess : made->guesses) print("  read as         {}\n", guess);
  if (made->trial)
    for (const std::string& line : trial_lines(*made->trial)) print("{}\n", line);
  if (made->learnt && made->learnt->bytes > 0)
    print("  tables          learnt from {}\n", counted(made->learnt->samples, "frame"));
  const std::string output = shell_word(options->output.string());
  print("  next            pack part I/N {} for each I from 1 to N, then pack join {}\n", output,
        output);
  return kExitOk;
}

struct PartArguments {
  std::filesystem::path output;
  PartOf part;
  int threads = 0;
  bool fail_fast = false;
};

Result<PartReport> run_part(const PartArguments& arguments, const PackListener& listener) {
  const PackPlan plan = TRY(read_plan(arguments.output));
  PackOptions options = TRY(parse_pack_command_line(plan.arguments));
  options.output = arguments.output;
  options.threads = arguments.threads;
  return pack_part(plan, std::move(options), arguments.part, arguments.fail_fast, listener);
}

int run_part(const PartArguments& arguments) {
  const StopSignal stop;
  PackProgress progress;
  const Result<PartReport> report = run_part(arguments, progress.listener(stop.token()));
  progress.done();
  if (!report) return failed(report.error());
  for (const Error& failure : report->failures) print_error(failure.message);
  print("part {}/{}: {} packed{}\n", arguments.part.index, arguments.part.count,
        counted(report->packed, "segment"),
        report->already > 0 ? fmt::format(", {} were there already", report->already) : "");
  return report->failures.empty() ? kExitOk : kExitFailed;
}

int run_join(const std::filesystem::path& output, bool force) {
  const Result<JoinReport> report = join_parts(output, force);
  if (!report) return failed(report.error());
  for (const std::string& line : report->warnings) print_error("warning: " + line);
  print("{}: {}, {}, {}\n", output.string(), counted(report->frames, "frame"),
        counted(report->segments, "segment"), counted(report->bytes, "byte"));
  if (report->audio) print("  sound           {}\n", encoded_audio_text(*report->audio));
  return kExitOk;
}

int run_submit(const SlurmOptions& options, bool wait) {
  const StopSignal stop;
  const Result<PackPlan> plan = read_plan(options.output);
  if (!plan) return failed(plan.error());
  const Result<SlurmJobs> jobs = submit_to_slurm(*plan, options);
  if (!jobs) return failed(jobs.error());
  print("job {} packs {}, job {} joins them\n", jobs->parts, counted(options.parts, "part"),
        jobs->join);
  if (!wait) return kExitOk;
  Progress progress("pack", plan->frames.size());
  std::uint32_t shown = 0;
  const auto show = [&](std::uint32_t done) {
    for (; shown < done; ++shown) progress.tick();
  };
  const Result<void> done = wait_for_slurm(*plan, options, *jobs, show, stop.token());
  if (!done) return failed(done.error());
  print("{}: complete\n", options.output.string());
  return kExitOk;
}

cli::Option add_output(cli::Command command, std::filesystem::path& output) {
  return command.add_option("-o,--output,REEL", output, "the same as that of pack plan")
      .required()
      .type_name("REEL");
}

void add_plan(cli::Command pack, int& exit_code) {
  const auto arguments = std::make_shared<PackArguments>();
  const cli::Command command =
      pack.add_subcommand("plan",
                          "Prepare packing in parts, on several machines that share a file system\n"
                          "Then run pack part I/N for each part, and pack join once all are done.");
  arguments->add_to(command);
  command.callback([arguments, &exit_code] { exit_code = run_plan(*arguments); });
}

void add_part(cli::Command pack, int& exit_code) {
  const auto arguments = std::make_shared<PartArguments>();
  const cli::Command command = pack.add_subcommand(
      "part", "Pack a part of a plan; run again, it goes on with what is missing");
  command
      .add_option_function<std::string>(
          "part", [a = arguments.get()](const std::string& text) { a->part = *parse_part(text); },
          "which of how many parts, such as 3/7")
      .check({[](const std::string& text) {
        return parse_part(text) ? std::string() : text + " is not a part such as 3/7";
      }})
      .required()
      .type_name("I/N");
  add_output(command, arguments->output);
  command.add_option("--threads", arguments->threads, "threads; 0: one for each processor")
      .check(cli::range(0, 1024))
      .capture_default_str();
  command.add_flag("--fail-fast", arguments->fail_fast,
                   "stop at the first segment that cannot be packed");
  command.callback([arguments, &exit_code] { exit_code = run_part(*arguments); });
}

void add_join(cli::Command pack, int& exit_code) {
  const auto output = std::make_shared<std::filesystem::path>();
  const cli::Command command =
      pack.add_subcommand("join", "Make the package of the parts of a plan");
  add_output(command, *output);
  const auto force = std::make_shared<bool>(false);
  command.add_flag("--force", *force, "replace a package that is already there");
  command.callback([output, force, &exit_code] { exit_code = run_join(*output, *force); });
}

void add_submit(cli::Command pack, int& exit_code) {
  struct Arguments {
    SlurmOptions options;
    bool slurm = true, no_wait = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  const cli::Command command =
      pack.add_subcommand("submit", "Hand the parts of a plan to the batch system Slurm");
  SlurmOptions& options = arguments->options;
  command.add_flag("--slurm", arguments->slurm, "hand them to Slurm (the only choice so far)");
  add_output(command, options.output);
  command.add_option("--parts", options.parts, "into how many jobs to divide the work")
      .required()
      .check(cli::range(1, 1'000'000))
      .type_name("N");
  command.add_option("--threads", options.threads, "processors for each job")
      .check(cli::range(1, 1024))
      .capture_default_str();
  command
      .add_option("--sbatch", options.sbatch,
                  "an argument for sbatch, such as --sbatch=--partition=NAME; may be repeated")
      .type_name("ARGUMENT");
  command.add_flag("--no-wait", arguments->no_wait, "return at once instead of showing progress");
  command.callback(
      [arguments, &exit_code] { exit_code = run_submit(arguments->options, !arguments->no_wait); });
}

}  // namespace

void add_parts_commands(cli::Command pack, int& exit_code) {
  pack.require_subcommand(0, 1);
  add_plan(pack, exit_code);
  add_part(pack, exit_code);
  add_join(pack, exit_code);
  add_submit(pack, exit_code);
}

}  // namespace pointreel
