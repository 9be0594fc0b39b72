#include "tests/bench/surface/captures.h"

namespace pointreel::bench {
namespace {

constexpr double kDepthNoise = 0.01;

}  // namespace

std::vector<Capture> surface_captures(bool quick) {
  std::vector<Capture> captures;
  for (const char* name : {"soccer-shoot", "kick", "baseball", "basketball", "soccer-juggle"}) {
    captures.push_back({kScans, find_motion(name), {}});
    if (quick) break;
  }
  for (const char* name : {"soccer-shoot", "kick", "baseball"}) {
    SequenceOptions options;
    options.sampler = Sampler::depth_cameras;
    options.depth_cameras.noise = kDepthNoise;
    captures.push_back({kDepthCameras, find_motion(name), options});
    if (quick) break;
  }
  return captures;
}

}  // namespace pointreel::bench
