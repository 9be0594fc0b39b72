#include "codec/audio/opus_writer.h"

#include <string_view>

#include <ogg/ogg.h>

#include "common/base/byte_io.h"

namespace pointreel {
namespace {

void put_text(Bytes& out, std::string_view text) {
  out.insert(out.end(), text.begin(), text.end());
}

Bytes head_packet(const OpusReader::Head& head) {
  Bytes bytes;
  bytes.reserve(64);
  put_text(bytes, "OpusHead");
  ByteWriter out(bytes);
  out.put(std::uint8_t{1});
  out.put(static_cast<std::uint8_t>(head.channels));
  out.put(static_cast<std::uint16_t>(head.skip));
  out.put(kAudioRate);
  out.put(static_cast<std::uint16_t>(head.gain));
  out.put(std::uint8_t{0});  // mono or stereo
  return bytes;
}

Bytes tags_packet() {
  constexpr std::string_view kVendor = "Pointreel";
  Bytes bytes;
  bytes.reserve(64);
  put_text(bytes, "OpusTags");
  ByteWriter out(bytes);
  out.put(static_cast<std::uint32_t>(kVendor.size()));
  put_text(bytes, kVendor);
  out.put(std::uint32_t{0});
  return bytes;
}

}  // namespace

class OpusWriter::Stream {
 public:
  Stream() { ogg_stream_init(&state, 1); }
  ~Stream() { ogg_stream_clear(&state); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  ogg_stream_state state{};
};

OpusWriter::OpusWriter(const std::filesystem::path& file, const OpusReader::Head& head)
    : out_(file, std::ios::binary | std::ios::trunc), stream_(std::make_unique<Stream>()) {
  // Each has a page of its own.
  for (const Bytes& packet : {head_packet(head), tags_packet()}) {
    put(packet, 0);
    write_pages(true);
  }
}

OpusWriter::~OpusWriter() = default;

void OpusWriter::put(ByteView packet, std::uint64_t end, bool last) {
  ogg_packet entry{};
  entry.packet = const_cast<unsigned char*>(packet.data());
  entry.bytes = static_cast<long>(packet.size());
  entry.b_o_s = number_ == 0;
  entry.e_o_s = last;
  entry.granulepos = static_cast<ogg_int64_t>(end);
  entry.packetno = number_++;
  ogg_stream_packetin(&stream_->state, &entry);
  write_pages(false);
}

void OpusWriter::flush() { write_pages(true); }

void OpusWriter::write_pages(bool all) {
  const auto next = all ? ogg_stream_flush : ogg_stream_pageout;
  const std::uint64_t before = bytes_;
  ogg_page page;
  while (next(&stream_->state, &page) != 0) {
    for (const ByteView part : {ByteView(page.header, static_cast<std::size_t>(page.header_len)),
                                ByteView(page.body, static_cast<std::size_t>(page.body_len))}) {
      out_.write(reinterpret_cast<const char*>(part.data()),
                 static_cast<std::streamsize>(part.size()));
      checksum_.add(part);
      bytes_ += part.size();
    }
  }
  // What a killed program has not handed to the system is lost.
  if (bytes_ > before) out_.flush();
}

}  // namespace pointreel
