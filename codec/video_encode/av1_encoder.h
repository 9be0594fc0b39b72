#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

struct Av1Options {
  int width = 0, height = 0;  ///< even, at least 64
  int bits = 8;               ///< 8 or 10
  int frames = 1;
  int quantizer = 32;  ///< 0 to 63
  int preset = 8;      ///< SVT-AV1's, 0 (slow) to 12 (fast)
  int threads = 1;     ///< does not change the bytes
};

/// Planes of 4:2:0. Samples of 10 bits take two bytes each.
struct Yuv {
  Bytes luma, cb, cr;
};

/// Encodes a closed group of pictures by SVT-AV1: the first is a key frame, and the temporal unit
/// of each needs those before it only. `picture` fills in picture i, whose planes have their sizes.
/// Errors: `limit` if the encoder cannot be opened, `invalid` if it fails.
Result<std::vector<Bytes>> encode_av1(const Av1Options& options,
                                      const std::function<void(int i, Yuv& picture)>& picture);

/// The library and its version, such as "SVT-AV1 1.4.1".
std::string av1_encoder_name();

}  // namespace pointreel
