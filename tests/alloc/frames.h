#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Something of every kind that the decoders read, made once.
namespace pointreel {

struct Decoding {
  std::string name;
  /// Decodes it, and returns how many points there are.
  std::function<Result<std::size_t>(const DecodeLimits&)> decode;
};

/// Frames of both codecs in every coding, and .drc files of clouds and meshes. `side`: the number
/// of points is its square, or its third power for one that is compressed much more than others.
std::vector<Decoding> all_decodings(int side);

}  // namespace pointreel
