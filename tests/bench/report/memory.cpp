#include "tests/bench/report/memory.h"

#include <string>
#include <vector>

#include "common/base/try.h"
#include "tests/bench/program.h"

namespace pointreel::bench {

Result<PeakMemory> measure_memory(const std::filesystem::path& input, const Setting& setting,
                                  const std::filesystem::path& scratch) {
  const std::string reel = scratch / "reel", frames = scratch / "frames";
  std::vector<std::string> pack = {"pack", "-i", input, "-o", reel, "--force", "--threads", "1"};
  pack.insert(pack.end(), setting.pack_arguments.begin(), setting.pack_arguments.end());
  const e2e::Outcome packed = TRY(run_program("pointreel-server", pack));
  std::filesystem::remove_all(frames);
  const e2e::Outcome unpacked =
      TRY(run_program("pointreel-server", {"unpack", "-i", reel, "-o", frames}));
  return PeakMemory{packed.peak_mib, unpacked.peak_mib};
}

}  // namespace pointreel::bench
