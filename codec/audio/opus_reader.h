#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// A sample of both channels, each in [-1, 1].
struct StereoSample {
  float left = 0.0f, right = 0.0f;
};

/// Decodes the sound of a reel (package.h, AudioFile) with libopusfile. Of files with one channel,
/// both channels are the same; files with more than two are mixed down.
///
/// Trust: the bytes may be hostile. A file of more than one stream is refused. `open` and `seek`
/// read at most kMostSearched bytes, and memory does not grow with the file. Samples are finite.
class OpusReader {
 public:
  /// Fills `bytes` with those of the file from `offset` on; all of them lie in the file.
  using ReadAt = std::function<Result<void>(std::uint64_t offset, std::span<std::uint8_t> bytes)>;

  static constexpr std::uint64_t kMostSearched = 32u << 20;

  /// Reads the header and the end of a file of `size` bytes. Errors: that of `read`; `invalid`.
  static Result<OpusReader> open(ReadAt read, std::uint64_t size);
  /// The same of bytes in memory, which must outlive it.
  static Result<OpusReader> open(ByteView bytes);
  /// Reads from a file, which must outlive the function. Errors: `io`.
  static ReadAt read_at(std::ifstream& file);
  OpusReader(OpusReader&&) noexcept;
  OpusReader& operator=(OpusReader&&) noexcept;
  ~OpusReader();

  /// How many samples the file says that it has.
  std::uint64_t samples() const;
  /// The number of the sample that `read` begins with, after parts that cannot be decoded too.
  std::uint64_t position() const;
  /// `read` goes on with this sample, or with the end of the file. Errors as for `open`.
  Result<void> seek(std::uint64_t sample);

  struct Read {
    std::size_t samples = 0;  ///< at the front of the buffer; 0 at the end of the file
    bool hole = false;        ///< something before them was left out, because it was damaged
  };
  /// Decodes up to as many samples as the buffer has, usually fewer. Errors as for `open`.
  Result<Read> read(std::span<StereoSample> buffer);

  /// What the decoder must know of the whole file.
  struct Head {
    int channels = 2;
    std::uint32_t skip = 0;  ///< samples before the first that is heard
    int gain = 0;            ///< in 1/256 dB
    bool plain = true;       ///< one or two channels, without a table of what they are

    bool operator==(const Head&) const = default;
  };
  Head head() const;

  /// A packet as it is in the file.
  struct Packet {
    Bytes bytes;
    std::uint32_t samples = 0;  ///< that it decodes to, 120 to 5,760
    std::int64_t first = 0;     ///< number of the first of them, from -Head::skip to 2^60
    std::int64_t end = 0;       ///< as far as it is heard, at most first + samples
  };
  struct Packets {
    std::vector<Packet> packets;  ///< none at the end of the file
    bool hole = false;            ///< something before them was left out, because it was damaged
  };
  /// The next packets, which are not decoded: those of a page at most, but for the first ones.
  /// Only for a reader of which nothing was read, and that has not sought. Errors as for `open`.
  Result<Packets> packets();

 private:
  class Impl;
  explicit OpusReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Decodes the samples from `first` on, all of them. What the file does not have, or is damaged,
/// is silence. Errors as for OpusReader::open.
Result<void> read_exactly(OpusReader& reader, std::uint64_t first, std::span<StereoSample> to);

}  // namespace pointreel
