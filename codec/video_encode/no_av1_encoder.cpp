// In place of av1_encoder.cpp where Pointreel is built without video.
#include "codec/video_encode/av1_encoder.h"

namespace pointreel {

Result<std::vector<Bytes>> encode_av1(const Av1Options&,
                                      const std::function<void(int i, Yuv& picture)>&) {
  return fail(ErrorCode::unsupported,
              "this Pointreel was built without video (POINTREEL_BUILD_VIDEO=OFF)");
}

std::string av1_encoder_name() { return "none"; }

}  // namespace pointreel
