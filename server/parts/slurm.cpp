#include "server/parts/slurm.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"
#include "common/process/run_program.h"
#include "server/parts/pack_part.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

std::string trimmed(std::string text) {
  while (!text.empty() && std::string_view(" \t\r\n").find(text.back()) != std::string_view::npos)
    text.pop_back();
  return text;
}

/// What a program of Slurm has said, in one line.
std::string in_one_line(const std::string& text) {
  std::istringstream lines(text);
  std::string said;
  for (std::string line; std::getline(lines, line);) {
    line = trimmed(line);
    if (!line.empty()) said += (said.empty() ? "" : "; ") + line;
  }
  return visible(said);
}

struct SubmittedJob {
  std::string id, cluster;
};

/// Submits a script.
Result<SubmittedJob> sbatch(std::vector<std::string> arguments, const fs::path& script) {
  arguments.insert(arguments.begin(), {"sbatch", "--parsable"});
  arguments.push_back(script.string());
  const ProgramOutcome outcome = TRY(run_program(arguments));
  std::string said = trimmed(outcome.out);
  if (outcome.exit_code != 0 || said.empty()) {
    return fail(ErrorCode::io, said.empty() ? fmt::format("sbatch ended with status {} and no word",
                                                          outcome.exit_code)
                                            : in_one_line(said));
  }
  // Warnings come first; with several clusters, the cluster's name comes after a semicolon.
  said.erase(0, said.rfind('\n') + 1);
  const std::size_t end = std::min(said.find(';'), said.size());
  return SubmittedJob{said.substr(0, end), said.substr(std::min(end + 1, said.size()))};
}

/// Arguments for a program of Slurm, which looks for jobs on its own cluster unless it is told.
std::vector<std::string> with_cluster(std::vector<std::string> arguments,
                                      const std::string& cluster) {
  if (!cluster.empty()) arguments.insert(arguments.begin() + 1, "--clusters=" + cluster);
  return arguments;
}

/// Whether Slurm still has one of the jobs, as far as it answers. It forgets ended ones, and says
/// so by an error; any other error says nothing of the jobs.
bool in_queue(const SlurmJobs& jobs) {
  const auto outcome = run_program(with_cluster(
      {"squeue", "--noheader", "--format=%i", "--jobs=" + jobs.parts + "," + jobs.join},
      jobs.cluster));
  if (!outcome) return false;
  if (outcome->exit_code != 0) return outcome->out.find("Invalid job id") == std::string::npos;
  // There may be warnings and names of clusters between the lines of the jobs.
  std::istringstream lines(outcome->out);
  for (std::string line; std::getline(lines, line);) {
    const std::string job = trimmed(line), id = job.substr(0, job.find('_'));
    if (id == jobs.parts || id == jobs.join) return true;
  }
  return false;
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

/// The log of a part; Slurm fills in "%a", the part's number.
fs::path part_log(const fs::path& folder, std::string_view part) {
  return folder / fmt::format("part-{}.log", part);
}
fs::path join_log(const fs::path& folder) { return folder / "join.log"; }

/// The error of the first part that is not all there and has written one, or else that of the join.
/// A part that has succeeded may have written what its first try failed of.
std::string error_of_jobs(const PackPlan& plan, const fs::path& folder, std::uint32_t parts) {
  for (std::uint32_t index = 1; index <= parts; ++index) {
    const PartOf part{index, parts};
    bool whole = true;
    std::error_code ignored;
    for (std::uint32_t s = part.first_segment(plan.segments());
         s < part.end_segment(plan.segments()); ++s)
      whole = whole && fs::exists(segment_manifest(folder, plan.first_frame(s)), ignored);
    if (whole) continue;
    const std::string error = last_error(part_log(folder, std::to_string(index)));
    if (!error.empty()) return fmt::format("part {}: {}", index, error);
  }
  const std::string error = last_error(join_log(folder));
  return error.empty() ? "no job has written an error; sacct may know why they ended" : error;
}

/// What jobs that were submitted before have written, which is not what these fail of.
void remove_old_logs(const fs::path& folder, std::uint32_t parts) {
  std::error_code ignored;
  for (std::uint32_t part = 1; part <= parts; ++part)
    fs::remove(part_log(folder, std::to_string(part)), ignored);
  fs::remove(join_log(folder), ignored);
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

  remove_old_logs(folder, options.parts);

  // A file name in which Slurm fills in "%a" must not have other percent signs.
  std::string logs = folder.string();
  for (std::size_t at = 0; (at = logs.find('%', at)) != std::string::npos; at += 2)
    logs.insert(at, 1, '%');
  const std::string name = fmt::format("--job-name=pack {}", plan.name);
  std::vector<std::string> arguments = {fmt::format("--array=1-{}", options.parts), name,
                                        fmt::format("--cpus-per-task={}", options.threads),
                                        "--output=" + part_log(logs, "%a").string()};
  arguments.insert(arguments.end(), options.sbatch.begin(), options.sbatch.end());
  const SubmittedJob packing = TRY(sbatch(std::move(arguments), part));

  arguments = {name, "--output=" + join_log(logs).string()};
  arguments.insert(arguments.end(), options.sbatch.begin(), options.sbatch.end());
  // Of several clusters, it must wait on the one that has the parts.
  if (!packing.cluster.empty()) arguments.push_back("--clusters=" + packing.cluster);
  arguments.insert(arguments.end(),
                   {"--dependency=afterok:" + packing.id, "--kill-on-invalid-dep=yes"});
  const Result<SubmittedJob> joining = sbatch(std::move(arguments), join);
  if (!joining) {
    (void)run_program(with_cluster({"scancel", packing.id}, packing.cluster));
    return tl::unexpected(joining.error());
  }
  return SlurmJobs{packing.id, joining->id, packing.cluster};
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
      return fail(
          ErrorCode::cancelled,
          fmt::format(
              "interrupted; the jobs go on, and {} ends them",
              fmt::join(with_cluster({"scancel", jobs.parts, jobs.join}, jobs.cluster), " ")));
    }
    if (look % kLooksPerQuestion == kLooksPerQuestion - 1 && !in_queue(jobs)) {
      if (joined()) return {};
      return fail(fmt::format("{} of {} packed; {}", count.now(),
                              counted(plan.frames.size(), "frame is", "frames are"),
                              error_of_jobs(plan, folder, options.parts)));
    }
    pause(options.look_every, stop);
  }
}

}  // namespace pointreel
