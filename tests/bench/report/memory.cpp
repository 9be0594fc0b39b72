#include "tests/bench/report/memory.h"

#include <string>
#include <vector>

#include "tests/e2e/process.h"

namespace pointreel::bench {
namespace {

Result<double> peak_of(const std::vector<std::string>& arguments) {
  constexpr int kSeconds = 600;
  const e2e::Outcome outcome = e2e::run("pointreel-server", arguments, kSeconds);
  if (outcome.exit_code != 0) return fail("pointreel-server: " + outcome.err);
  return outcome.peak_mib;
}

}  // namespace

Result<PeakMemory> measure_memory(const std::filesystem::path& input, const Setting& setting,
                                  const std::filesystem::path& scratch) {
  const std::string reel = scratch / "reel", frames = scratch / "frames";
  std::vector<std::string> pack = {"pack", "-i", input, "-o", reel, "--force", "--threads", "1"};
  pack.insert(pack.end(), setting.pack_arguments.begin(), setting.pack_arguments.end());
  const Result<double> packing = peak_of(pack);
  if (!packing) return tl::unexpected(packing.error());
  std::filesystem::remove_all(frames);
  const Result<double> unpacking = peak_of({"unpack", "-i", reel, "-o", frames});
  if (!unpacking) return tl::unexpected(unpacking.error());
  return PeakMemory{*packing, *unpacking};
}

}  // namespace pointreel::bench
