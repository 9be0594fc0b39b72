#include "server/parts/slurm.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <set>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"
#include "common/process/run_program.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using namespace std::chrono_literals;

std::string trimmed(std::string text) {
  while (!text.empty() && std::string_view(" \t\r\n").find(text.back()) != std::string_view::npos)
    text.pop_back();
  return text;
}

/// Submits a script, and returns the number of the job.
Result<std::string> sbatch(std::vector<std::string> arguments, const SlurmOptions& options,
                           const fs::path& script) {
  arguments.insert(arguments.begin(), {"sbatch", "--parsable"});
  arguments.insert(arguments.end(), options.sbatch.begin(), options.sbatch.end());
  arguments.push_back(script.string());
  const ProgramOutcome outcome = TRY(run_program(arguments));
  std::string id = trimmed(outcome.out);
  if (outcome.exit_code != 0) return fail(ErrorCode::io, visible(id.substr(0, id.find('\n'))));
  // Warnings come first; with several clusters, the cluster's name comes after a semicolon.
  id.erase(0, id.rfind('\n') + 1);
  id.erase(std::min(id.find(';'), id.size()));
  return id;
}

/// Whether Slurm still has one of the jobs. It forgets ended ones, and says so by an error.
bool in_queue(const SlurmJobs& jobs) {
  const auto outcome =
      run_program({"squeue", "--noheader", "--jobs=" + jobs.parts + "," + jobs.join});
  return outcome && outcome->exit_code == 0 && !trimmed(outcome->out).empty();
}

/// Counts the frames of the segments that are there, each of which is asked about only until it is.
class FrameCount {
 public:
  FrameCount(const PackPlan& plan, fs::path folder) : plan_(plan), folder_(std::move(folder)) {
    for (std::uint32_t s = 0; s < plan.segments(); ++s) missing_.insert(missing_.end(), s);
  }

  std::uint32_t now() {
    std::erase_if(missing_, [&](std::uint32_t segment) {
      std::error_code ignored;
      if (!fs::exists(segment_manifest(folder_, plan_.first_frame(segment)), ignored)) return false;
      frames_ += static_cast<std::uint32_t>(plan_.frames_of(segment).size());
      return true;
    });
    return frames_;
  }

 private:
  const PackPlan& plan_;
  const fs::path folder_;
  std::set<std::uint32_t> missing_;
  std::uint32_t frames_ = 0;
};

/// The last error in what a job has written, for people; empty if there is none.
std::string last_error(const fs::path& log) {
  constexpr std::string_view kOurs = "pointreel-server: ", kSlurms = "slurmstepd: error: ";
  std::ifstream in(log);
  std::string line, last;
  while (std::getline(in, line)) {
    for (const std::string_view mark : {kOurs, kSlurms}) {
      if (line.starts_with(mark)) last = line.substr(mark.size());
    }
  }
  return visible(last);
}

/// The first job that has written an error, and its error.
std::string error_of_jobs(const fs::path& folder, std::uint32_t parts) {
  for (std::uint32_t part = 1; part <= parts; ++part) {
    const std::string error = last_error(folder / fmt::format("part-{}.log", part));
    if (!error.empty()) return fmt::format("part {}: {}", part, error);
  }
  const std::string error = last_error(folder / "join.log");
  return error.empty() ? "no job has written an error; sacct may know why they ended" : error;
}

void pause(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any().wait_for(lock, stop, time, [] { return false; });
}

}  // namespace

Result<SlurmJobs> submit_to_slurm(const PackPlan& plan, const SlurmOptions& options) {
  const fs::path folder = parts_folder(options.output);
  std::error_code error;
  const std::string program = shell_word(fs::read_symlink("/proc/self/exe", error).string());
  const std::string output = shell_word(fs::absolute(options.output, error).string());
  if (error) return fail(ErrorCode::io, error.message());
  const fs::path part = folder / "part.sh", join = folder / "join.sh";
  const std::string pack_part =
      fmt::format("{} pack part \"$SLURM_ARRAY_TASK_ID/{}\" -o {} --threads {}", program,
                  options.parts, output, options.threads);
  // The second try packs what the first one did not.
  TRY(write_file(part, fmt::format("#!/bin/sh\n{0} && exit 0\nexec {0}\n", pack_part)));
  TRY(write_file(join, fmt::format("#!/bin/sh\nexec {} pack join -o {}\n", program, output)));

  const std::string name = fmt::format("--job-name=pack {}", plan.name);
  SlurmJobs jobs;
  // A file name in which Slurm fills in "%a" must not have other percent signs.
  std::string logs = folder.string();
  for (std::size_t at = 0; (at = logs.find('%', at)) != std::string::npos; at += 2)
    logs.insert(at, 1, '%');
  jobs.parts = TRY(sbatch({fmt::format("--array=1-{}", options.parts), name,
                           fmt::format("--cpus-per-task={}", options.threads),
                           fmt::format("--output={}/part-%a.log", logs)},
                          options, part));
  Result<std::string> joining =
      sbatch({"--dependency=afterok:" + jobs.parts, "--kill-on-invalid-dep=yes", name,
              fmt::format("--output={}/join.log", logs)},
             options, join);
  if (!joining) {
    (void)run_program({"scancel", jobs.parts});
    return tl::unexpected(joining.error());
  }
  jobs.join = std::move(*joining);
  return jobs;
}

Result<void> wait_for_slurm(const PackPlan& plan, const SlurmOptions& options,
                            const SlurmJobs& jobs,
                            const std::function<void(std::uint32_t)>& frames_done,
                            const std::stop_token& stop) {
  const fs::path folder = parts_folder(options.output);
  FrameCount count(plan, folder);
  // The join removes the folder of the parts when the package is in place.
  const auto joined = [&] {
    std::error_code ignored;
    return !fs::exists(folder, ignored) && fs::exists(options.output / kManifestName, ignored);
  };
  constexpr int kLooksPerQuestion = 10;  // squeue asks a server that others need, too
  for (int look = 0;; ++look) {
    if (joined()) return {};
    frames_done(count.now());
    if (stop.stop_requested()) {
      return fail(ErrorCode::cancelled,
                  fmt::format("interrupted; the jobs go on, and scancel {} {} ends them",
                              jobs.parts, jobs.join));
    }
    if (look % kLooksPerQuestion == kLooksPerQuestion - 1 && !in_queue(jobs)) {
      if (joined()) return {};
      return fail(fmt::format("{} of {} packed; {}", count.now(),
                              counted(plan.frames.size(), "frame is", "frames are"),
                              error_of_jobs(folder, options.parts)));
    }
    pause(500ms, stop);
  }
}

}  // namespace pointreel
