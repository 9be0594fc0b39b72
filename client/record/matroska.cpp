#include "client/record/matroska.h"

#include <string_view>

namespace pointreel {
namespace {

std::string big_endian(std::uint64_t value, std::size_t bytes) {
  std::string text;
  for (std::size_t i = bytes; i-- > 0;) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

/// The identifier of an element and its size, which always takes eight bytes.
std::string begin(std::uint32_t id, std::uint64_t size) {
  const std::size_t id_bytes = id > 0xffffff ? 4 : id > 0xffff ? 3 : id > 0xff ? 2 : 1;
  return big_endian(id, id_bytes) + big_endian((std::uint64_t{1} << 56) | size, 8);
}

std::string element(std::uint32_t id, std::string_view content) {
  return begin(id, content.size()) + std::string(content);
}

std::string number(std::uint32_t id, std::uint64_t value) {
  return element(id, big_endian(value, 8));
}

constexpr std::uint64_t kUnknownSize = (std::uint64_t{1} << 56) - 1;

}  // namespace

std::string matroska_head(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint64_t kMicrosecond = 1000;                        // in nanoseconds
  const std::string ebml = element(0x4282, "matroska")                // DocType
                           + number(0x4287, 4)                        // DocTypeVersion
                           + number(0x4285, 2);                       // DocTypeReadVersion
  const std::string info = number(0x2AD7B1, kMicrosecond)             // TimestampScale
                           + element(0x4D80, "pointreel")             // MuxingApp
                           + element(0x5741, "pointreel");            // WritingApp
  const std::string video = number(0xB0, width)                       // PixelWidth
                            + number(0xBA, height)                    // PixelHeight
                            + element(0x2EB524, "RGB\x18");           // UncompressedFourCC
  const std::string track = number(0xD7, 1)                           // TrackNumber
                            + number(0x73C5, 1)                       // TrackUID
                            + number(0x83, 1)                         // TrackType: video
                            + number(0x23E383, 1000 * kPictureUs)     // DefaultDuration
                            + element(0x86, "V_UNCOMPRESSED")         // CodecID
                            + element(0xE0, video);                   // Video
  return element(0x1A45DFA3, ebml) + begin(0x18538067, kUnknownSize)  // Segment
         + element(0x1549A966, info) + element(0x1654AE6B, element(0xAE, track));
}

std::string matroska_picture_head(std::uint64_t time_us, std::size_t picture_bytes) {
  // Each picture is a cluster with one block, because times of blocks have only 16 bits.
  const std::string block("\x81\0\0\x80", 4);  // track 1, at the cluster's time, key frame
  const std::string time = number(0xE7, time_us);
  const std::string simple = begin(0xA3, block.size() + picture_bytes) + block;
  return begin(0x1F43B675, time.size() + simple.size() + picture_bytes) + time + simple;
}

}  // namespace pointreel
