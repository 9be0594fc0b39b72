#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

struct Dav1dContext;

namespace pointreel {

/// A plane of a picture in somebody else's memory.
template <class Sample>
struct PlaneView {
  const Sample* samples = nullptr;
  std::ptrdiff_t stride = 0;  ///< from a row to the next, in samples

  const Sample* from(int x, int y) const { return samples + y * stride + x; }
};

/// What a decoder of AV1 must give, or the picture is an error.
struct Av1Format {
  int width = 0, height = 0;
  int bits = 8;  ///< 8 or 10
};

/// A decoded picture in 4:2:0: `depth` if it has 10 bits, else `luma` and both chroma planes.
/// Copies share its memory.
struct Av1Picture {
  std::shared_ptr<const void> memory;
  PlaneView<std::uint16_t> depth;
  PlaneView<std::uint8_t> luma, cb, cr;
};

/// Decodes AV1, one picture from each temporal unit, by dav1d.
///
/// Trust: the bytes may be hostile. Pictures of more pixels than the format has are refused before
/// memory is taken for them.
class Av1Decoder {
 public:
  static Result<Av1Decoder> open(const Av1Format& format, int threads = 1);

  /// Errors: `invalid` if the bytes are damaged, hold no picture, or one of another format.
  Result<Av1Picture> decode(ByteView temporal_unit);

 private:
  class Impl;
  struct Close {
    void operator()(Impl* impl) const;
  };
  explicit Av1Decoder(Impl* impl) : impl_(impl) {}
  std::unique_ptr<Impl, Close> impl_;
};

}  // namespace pointreel
