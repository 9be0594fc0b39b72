#include "codec/audio/opus_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <opus/opusfile.h>

#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

const char* text_of(int error) {
  switch (error) {
    case OP_ENOTFORMAT:
      return "is not Opus in Ogg";
    case OP_EVERSION:
      return "has a newer version of Opus";
    case OP_EIMPL:
      return "uses a feature of Opus that is not supported";
    case OP_EFAULT:
      return "not enough memory";
    default:
      return "is damaged";
  }
}

}  // namespace

class OpusReader::Impl {
 public:
  Impl(ReadAt read, std::uint64_t size) : read_at_(std::move(read)), size_(size) {}
  ~Impl() { op_free(file_); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<void> open() {
    const OpusFileCallbacks callbacks = {&Impl::read, &Impl::seek, &Impl::tell, nullptr};
    searched_ = 0;
    int error = 0;
    file_ = op_open_callbacks(this, &callbacks, nullptr, 0, &error);
    if (!file_) return failed(error);
    if (op_link_count(file_) != 1) return fail("holds several streams, and only one is read");
    if (samples() == 0) return fail("has no samples");
    return {};
  }

  std::uint64_t samples() const {
    return static_cast<std::uint64_t>(std::max<ogg_int64_t>(0, op_pcm_total(file_, -1)));
  }

  std::uint64_t position() const {
    return static_cast<std::uint64_t>(std::max<ogg_int64_t>(0, op_pcm_tell(file_)));
  }

  Result<void> seek_to(std::uint64_t sample) {
    searched_ = 0;
    const int error =
        op_pcm_seek(file_, static_cast<ogg_int64_t>(std::min<std::uint64_t>(sample, samples())));
    if (error < 0) return failed(error);
    return {};
  }

  Result<Read> read(std::span<StereoSample> buffer) {
    static_assert(sizeof(StereoSample) == 2 * sizeof(float));
    Read read;
    const auto room = static_cast<int>(
        std::min<std::size_t>(2 * buffer.size(), std::numeric_limits<int>::max() / 2));
    // Each hole takes bytes of the file, but a file may be full of them.
    searched_ = 0;
    int decoded = 0;
    while ((decoded = op_read_float_stereo(file_, &buffer.data()->left, room)) == OP_HOLE)
      read.hole = true;
    if (decoded < 0) return failed(decoded);
    read.samples = static_cast<std::size_t>(decoded);
    const auto usable = [](float x) { return std::isfinite(x) ? std::clamp(x, -1.0f, 1.0f) : 0; };
    for (StereoSample& sample : buffer.first(read.samples))
      sample = {usable(sample.left), usable(sample.right)};
    return read;
  }

  Head head() const {
    const OpusHead& head = *op_head(file_, -1);
    return {head.channel_count, head.pre_skip, head.output_gain, head.mapping_family == 0};
  }

  Result<Packets> packets() {
    op_set_decode_callback(file_, &Impl::take, this);
    taken_ = {};
    // There is room for the longest packet, so that nothing of one is left for the next call.
    std::vector<StereoSample> unused(5760);
    const Result<Read> read = this->read(unused);
    op_set_decode_callback(file_, nullptr, nullptr);
    if (!read) return tl::unexpected(read.error());
    taken_.hole = read->hole;
    number_taken();
    return std::move(taken_);
  }

 private:
  static constexpr std::int64_t kFarthest = std::int64_t{1} << 60;

  /// From the granule positions of packets to the numbers of samples.
  void number_taken() {
    if (taken_.packets.empty()) return;
    if (!zero_) {
      zero_ = difference(taken_.packets.back().end, static_cast<std::int64_t>(position()));
      last_end_ = -static_cast<std::int64_t>(head().skip);
    }
    for (Packet& packet : taken_.packets) {
      // Positions in hostile files may be anything.
      const std::int64_t end = std::clamp(difference(packet.end, *zero_), -kFarthest, kFarthest);
      // The last packet may be heard in part only, and ends sooner.
      packet.first = std::max(last_end_, difference(end, packet.samples));
      packet.end = last_end_ = std::max(packet.first, end);
    }
  }

  /// Modulo 2^64, as positions are.
  static std::int64_t difference(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
  }

  /// Takes a packet in place of decoding it.
  static int take(void* self, OpusMSDecoder*, void* samples, const ogg_packet* packet, int count,
                  int channels, int format, int) {
    Impl& impl = *static_cast<Impl*>(self);
    Packet& taken = impl.taken_.packets.emplace_back();
    taken.bytes.assign(packet->packet, packet->packet + packet->bytes);
    taken.samples = static_cast<std::uint32_t>(count);
    taken.end = packet->granulepos;
    const std::size_t size = format == OP_DEC_FORMAT_FLOAT ? sizeof(float) : sizeof(opus_int16);
    std::memset(samples, 0, static_cast<std::size_t>(count * channels) * size);
    return 0;
  }

  tl::unexpected<Error> failed(int error) {
    if (error_) return tl::unexpected(*std::exchange(error_, std::nullopt));
    return fail(text_of(error));
  }

  // The file, as opusfile wants it.

  static int read(void* self, unsigned char* to, int count) {
    Impl& impl = *static_cast<Impl*>(self);
    const std::uint64_t left = impl.size_ - std::min(impl.offset_, impl.size_);
    const std::uint64_t size = std::min(left, static_cast<std::uint64_t>(std::max(count, 0)));
    if (size == 0) return 0;
    impl.searched_ += size;
    Result<void> done = impl.searched_ > kMostSearched
                            ? fail(concat("no sound in ", kMostSearched, " bytes"))
                            : impl.read_at_(impl.offset_, {to, static_cast<std::size_t>(size)});
    if (!done) {
      impl.error_ = std::move(done.error());
      return -1;
    }
    impl.offset_ += size;
    return static_cast<int>(size);
  }

  static int seek(void* self, opus_int64 offset, int from) {
    Impl& impl = *static_cast<Impl*>(self);
    const auto size = static_cast<std::int64_t>(impl.size_);
    const std::int64_t start = from == SEEK_SET   ? 0
                               : from == SEEK_CUR ? static_cast<std::int64_t>(impl.offset_)
                                                  : size;
    if (offset < -start || offset > size - start) return -1;
    impl.offset_ = static_cast<std::uint64_t>(start + offset);
    return 0;
  }

  static opus_int64 tell(void* self) {
    return static_cast<opus_int64>(static_cast<Impl*>(self)->offset_);
  }

  const ReadAt read_at_;
  const std::uint64_t size_;
  std::uint64_t offset_ = 0;
  std::uint64_t searched_ = 0;  ///< bytes read since the call began
  std::optional<Error> error_;  ///< of read_at_
  OggOpusFile* file_ = nullptr;
  Packets taken_;                     ///< by the present call of packets()
  std::optional<std::int64_t> zero_;  ///< granule position of the first sample that is heard
  std::int64_t last_end_ = 0;         ///< Packet::end of the packet taken last
};

OpusReader::OpusReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OpusReader::OpusReader(OpusReader&&) noexcept = default;
OpusReader& OpusReader::operator=(OpusReader&&) noexcept = default;
OpusReader::~OpusReader() = default;

Result<OpusReader> OpusReader::open(ReadAt read, std::uint64_t size) {
  auto impl = std::make_unique<Impl>(std::move(read), size);
  TRY(impl->open());
  return OpusReader(std::move(impl));
}

OpusReader::ReadAt OpusReader::read_at(std::ifstream& file) {
  return [&file](std::uint64_t offset, std::span<std::uint8_t> bytes) -> Result<void> {
    file.clear();
    file.seekg(static_cast<std::streamoff>(offset));
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file) return fail(ErrorCode::io, "cannot be read");
    return {};
  };
}

Result<OpusReader> OpusReader::open(ByteView bytes) {
  return open(
      [bytes](std::uint64_t offset, std::span<std::uint8_t> to) -> Result<void> {
        std::copy_n(bytes.data() + offset, to.size(), to.data());
        return {};
      },
      bytes.size());
}

std::uint64_t OpusReader::samples() const { return impl_->samples(); }
std::uint64_t OpusReader::position() const { return impl_->position(); }
Result<void> OpusReader::seek(std::uint64_t sample) { return impl_->seek_to(sample); }
Result<OpusReader::Read> OpusReader::read(std::span<StereoSample> buffer) {
  return impl_->read(buffer);
}
OpusReader::Head OpusReader::head() const { return impl_->head(); }
Result<OpusReader::Packets> OpusReader::packets() { return impl_->packets(); }

Result<void> read_exactly(OpusReader& reader, std::uint64_t first, std::span<StereoSample> to) {
  std::fill(to.begin(), to.end(), StereoSample{});
  const std::uint64_t end = first + to.size();
  if (reader.position() != first) TRY(reader.seek(first));
  std::vector<StereoSample> part(to.size());
  // A hostile file may never get there.
  for (std::size_t got = 0; reader.position() < end && got < 4 * part.size();) {
    const std::uint64_t left = end - std::max(first, reader.position());
    const OpusReader::Read read = TRY(reader.read(std::span(part).first(left)));
    if (read.samples == 0) break;
    got += read.samples;
    // After something damaged, what is left begins later.
    const std::uint64_t begin =
        reader.position() - std::min<std::uint64_t>(reader.position(), read.samples);
    for (std::size_t i = 0; i < read.samples; ++i)
      if (begin + i >= first && begin + i < end) to[begin + i - first] = part[i];
  }
  return {};
}

}  // namespace pointreel
