// In place of av1_decoder.cpp where Pointreel is built without video.
#include "codec/video/av1_decoder.h"

namespace pointreel {

class Av1Decoder::Impl {};

void Av1Decoder::Close::operator()(Impl* impl) const { delete impl; }

Result<Av1Decoder> Av1Decoder::open(const Av1Format&, int) {
  return fail(ErrorCode::unsupported,
              "this Pointreel was built without video (POINTREEL_BUILD_VIDEO=OFF)");
}

Result<Av1Picture> Av1Decoder::decode(ByteView) { return Av1Picture{}; }

}  // namespace pointreel
