#include "codec/files/video_pictures.h"

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/codec.h"

namespace pointreel {
namespace {

/// So many pictures are rather decoded than jumped over: starting ffmpeg takes about as long.
constexpr std::size_t kAhead = 32;
/// A jump back begins so many pictures earlier, because one before it is asked for next when a reel
/// is played backward.
constexpr std::size_t kBack = 8;
/// Threads that pack a long segment read from as many places at once.
constexpr std::size_t kDecoders = 4;
constexpr std::uint64_t kMostMemory = std::uint64_t{256} << 20;

std::string header_of(const VideoTrack& track, TrackPictures::Kind kind) {
  const bool depth = kind == TrackPictures::Kind::depth;
  return concat(depth ? "P5\n" : "P6\n", track.width, " ", track.height, "\n",
                depth ? "65535\n" : "255\n");
}

std::size_t pixel_bytes(TrackPictures::Kind kind) {
  return kind == TrackPictures::Kind::depth ? 2 : 3;
}

/// The first line of what ffmpeg said about pictures; empty if there is none. What it says about
/// the file, such as that it was cut, is no damage of those that are there.
std::string_view complaint_in(std::string_view said) {
  while (!said.empty()) {
    const std::string_view line = said.substr(0, said.find('\n'));
    if (!line.starts_with("[matroska")) return line;
    said.remove_prefix(std::min(line.size() + 1, said.size()));
  }
  return {};
}

}  // namespace

TrackPictures::TrackPictures(std::filesystem::path file, VideoTrack track, Kind kind,
                             std::uint64_t max_memory)
    : file_(std::move(file)),
      track_(std::move(track)),
      kind_(kind),
      most_kept_(static_cast<std::size_t>(std::max<std::uint64_t>(
          1, std::min(kMostMemory, max_memory) /
                 (std::uint64_t{track_.width} * track_.height * pixel_bytes(kind))))) {}

Result<std::shared_ptr<const Bytes>> TrackPictures::read(std::size_t picture) {
  const std::lock_guard lock(mutex_);
  for (const auto& [number, kept] : kept_)
    if (number == picture) return kept;
  Decoder& decoder = *TRY(decoder_for(picture));
  decoder.asked = ++asked_;
  for (;;) {
    Result<Picture> decoded = decode_next(decoder);
    if (!decoded) {
      std::erase_if(decoders_, [&](const auto& d) { return d.get() == &decoder; });
      return tl::unexpected(decoded.error());
    }
    const std::size_t number = decoder.next - 1;
    keep(number, *decoded);
    if (number == picture) return *decoded;
  }
}

Result<TrackPictures::Decoder*> TrackPictures::decoder_for(std::size_t picture) {
  Decoder* nearest = nullptr;
  bool is_back = false;
  for (const auto& decoder : decoders_) {
    is_back |= picture < decoder->next && decoder->next - picture <= 2 * kBack;
    if (picture < decoder->next || picture - decoder->next > kAhead) continue;
    if (nearest == nullptr || decoder->next > nearest->next) nearest = decoder.get();
  }
  if (nearest != nullptr) return nearest;
  std::size_t first = is_back ? picture - std::min(picture, kBack) : picture;
  while (first > 0 && !track_.is_key[first]) --first;
  auto fresh = std::make_unique<Decoder>();
  TRY(start(*fresh, first));
  if (decoders_.size() < kDecoders) {
    decoders_.push_back(std::move(fresh));
    return decoders_.back().get();
  }
  const auto least =
      std::min_element(decoders_.begin(), decoders_.end(),
                       [](const auto& a, const auto& b) { return a->asked < b->asked; });
  *least = std::move(fresh);
  return least->get();
}

Result<void> TrackPictures::start(Decoder& decoder, std::size_t at) const {
  std::vector<std::string> arguments{"-protocol_whitelist",
                                     "file",
                                     "-f",
                                     "matroska",
                                     "-max_pixels",
                                     concat(DecodeLimits().max_points)};
  const auto add = [&](std::initializer_list<std::string> more) {
    arguments.insert(arguments.end(), more);
  };
  if (at > 0) {
    // Between two pictures, since times are rounded.
    const std::uint64_t time = (track_.times_us[at - 1] + track_.times_us[at]) / 2;
    add({"-ss", concat(time, "us")});
  }
  add({"-noautorotate", "-i", "file:" + file_.string(), "-map", concat("0:", track_.index),
       "-fps_mode", "passthrough", "-s", concat(track_.width, "x", track_.height), "-pix_fmt",
       kind_ == Kind::depth ? "gray16be" : "rgb24", "-f", "rawvideo", "pipe:1"});
  Result<FfmpegOutput> started = FfmpegOutput::start(arguments, "ffmpeg");
  if (!started && started.error().code == ErrorCode::not_found)
    return fail(ErrorCode::not_found, kVideoNeedsFfmpeg);
  decoder.output.emplace(TRY(std::move(started)));
  decoder.first = decoder.next = at;
  return {};
}

Result<TrackPictures::Picture> TrackPictures::decode_next(Decoder& decoder) {
  const std::string header = header_of(track_, kind_);
  Bytes bytes(header.size() + std::size_t{track_.width} * track_.height * pixel_bytes(kind_));
  std::copy(header.begin(), header.end(), bytes.begin());
  const std::span<std::uint8_t> pixels = std::span(bytes).subspan(header.size());
  const bool whole = TRY(decoder.output->read(pixels)) == pixels.size();
  const std::string said = decoder.output->said();
  const std::string_view complaint = complaint_in(said);
  // It jumps to where another track can be decoded. If this one cannot, or if the first picture is
  // damaged, it complains, and what it gives may be a later picture.
  const bool damaged = !whole || (kind_ == Kind::depth && !complaint.empty());
  if (damaged && decoder.first > 0) {
    TRY(start(decoder, 0));
    return decode_next(decoder);
  }
  if (damaged)
    return fail(concat("is damaged, or a picture near it", complaint.empty() ? "" : ": ",
                       printable(complaint)));
  ++decoder.next;
  return std::make_shared<const Bytes>(std::move(bytes));
}

void TrackPictures::keep(std::size_t number, Picture picture) {
  if (kept_.size() < most_kept_) {
    kept_.emplace_back(number, std::move(picture));
    return;
  }
  kept_[oldest_] = {number, std::move(picture)};
  oldest_ = (oldest_ + 1) % kept_.size();
}

}  // namespace pointreel
