#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "server/parts/plan.h"

namespace pointreel {

struct SlurmOptions {
  std::filesystem::path output;     ///< that the plan was made for
  std::uint32_t parts = 1;          ///< jobs of the array
  int threads = 1;                  ///< processors for each of them
  std::vector<std::string> sbatch;  ///< more arguments for sbatch, such as --partition=NAME
  /// How often the folder of the plan is looked at; Slurm is asked a tenth as often.
  std::chrono::milliseconds look_every{500};
};

struct SlurmJobs {
  std::string parts;    ///< the array of the parts
  std::string join;     ///< the job that joins them; it waits until all parts are packed
  std::string cluster;  ///< where they are, if sbatch was given --clusters; else empty
};

/// Hands a plan to Slurm: an array of jobs that run `pack part`, each of them twice if the first
/// try fails, and a job that runs `pack join` once all have succeeded. The scripts and the jobs'
/// output are in the folder of the plan. Uses the program sbatch; the error holds its message.
Result<SlurmJobs> submit_to_slurm(const PackPlan& plan, const SlurmOptions& options);

/// Waits until both jobs have ended, and calls `frames_done` with the number of frames that are
/// packed. The package is what tells success: Slurm drops the join if a part fails. The error then
/// holds the error of a part that is missing. If `stop` is requested, returns the error
/// `cancelled`, and the jobs go on.
Result<void> wait_for_slurm(const PackPlan& plan, const SlurmOptions& options,
                            const SlurmJobs& jobs,
                            const std::function<void(std::uint32_t)>& frames_done,
                            const std::stop_token& stop);

}  // namespace pointreel
