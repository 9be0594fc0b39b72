#include "client/sound/audio_track.h"

#include <algorithm>
#include <list>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/try.h"

namespace pointreel {
namespace {

/// Two seconds of sound, so that the first ones are soon there over a slow link.
constexpr std::uint64_t kPiece = 32u << 10;
constexpr std::size_t kMostPieces = 16;

class Pieces {
 public:
  Pieces(std::uint64_t size, AudioTrack::Fetch fetch, std::stop_token stop)
      : size_(size), fetch_(std::move(fetch)), stop_(std::move(stop)) {}

  Result<void> read(std::uint64_t offset, std::span<std::uint8_t> to) {
    while (!to.empty()) {
      const Piece& piece = TRY(at(offset / kPiece));
      const std::size_t skip = offset % kPiece;
      const std::size_t size = std::min(to.size(), piece.bytes.size() - skip);
      std::copy_n(piece.bytes.begin() + static_cast<std::ptrdiff_t>(skip), size, to.begin());
      to = to.subspan(size);
      offset += size;
    }
    return {};
  }

 private:
  struct Piece {
    std::uint64_t number = 0;
    Bytes bytes;
  };

  /// The piece stays until others are asked for.
  Result<std::reference_wrapper<const Piece>> at(std::uint64_t number) {
    const auto found = std::find_if(pieces_.begin(), pieces_.end(),
                                    [=](const Piece& piece) { return piece.number == number; });
    if (found != pieces_.end()) {
      pieces_.splice(pieces_.begin(), pieces_, found);
      return std::cref(pieces_.front());
    }
    const std::uint64_t begin = number * kPiece;
    Bytes bytes = TRY(fetch_(begin, std::min(kPiece, size_ - begin), stop_));
    pieces_.push_front({number, std::move(bytes)});
    if (pieces_.size() > kMostPieces) pieces_.pop_back();
    return std::cref(pieces_.front());
  }

  const std::uint64_t size_;
  const AudioTrack::Fetch fetch_;
  const std::stop_token stop_;
  std::list<Piece> pieces_;  ///< the one used last comes first
};

}  // namespace

OpusReader::ReadAt in_pieces(std::uint64_t size, AudioTrack::Fetch fetch, std::stop_token stop) {
  const auto pieces = std::make_shared<Pieces>(size, std::move(fetch), std::move(stop));
  return [pieces](std::uint64_t offset, std::span<std::uint8_t> to) {
    return pieces->read(offset, to);
  };
}

AudioTrack::AudioTrack(const AudioFile& file, Fetch fetch, OnError on_error)
    : file_(file),
      fetch_(std::move(fetch)),
      on_error_(std::move(on_error)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

bool AudioTrack::copy(std::int64_t first, std::span<StereoSample> to) {
  std::fill(to.begin(), to.end(), StereoSample{});
  const auto end = static_cast<std::int64_t>(file_.samples);
  const std::int64_t last = std::min(first + static_cast<std::int64_t>(to.size()), end);
  bool complete = true;
  const std::lock_guard lock(mutex_);
  for (std::int64_t at = std::max<std::int64_t>(first, 0); at < last;) {
    const std::int64_t number = at / kBlock, skip = at % kBlock;
    const std::int64_t size = std::min(last - at, kBlock - skip);
    const auto found = blocks_.find(number);
    if (found == blocks_.end()) {
      complete = false;
    } else {
      std::copy_n(found->second.begin() + skip, size, to.begin() + (at - first));
    }
    at += size;
  }
  return complete;
}

void AudioTrack::want(const std::vector<std::int64_t>& samples) {
  const auto end = static_cast<std::int64_t>(file_.samples);
  std::vector<std::int64_t> blocks;
  for (const std::int64_t sample : samples) {
    const std::int64_t block = sample / kBlock;
    if (sample >= 0 && sample < end &&
        std::find(blocks.begin(), blocks.end(), block) == blocks.end())
      blocks.push_back(block);
    if (blocks.size() == kMostBlocks) break;
  }
  const std::lock_guard lock(mutex_);
  if (wanted_ == blocks) return;
  wanted_ = std::move(blocks);
  changed_.notify_one();
}

void AudioTrack::run(const std::stop_token& stop) {
  const Result<void> decoded = decode(stop);
  if (!decoded && !stop.stop_requested() && decoded.error().code != ErrorCode::cancelled)
    on_error_(decoded.error());
}

Result<void> AudioTrack::decode(const std::stop_token& stop) {
  const OpusReader::ReadAt read = in_pieces(file_.bytes, fetch_, stop);
  OpusReader reader = TRY(OpusReader::open(read, file_.bytes));
  bool damaged = false;
  for (;;) {
    std::optional<std::int64_t> next;
    {
      std::unique_lock lock(mutex_);
      const auto missing = [&] {
        const auto found = std::find_if(wanted_.begin(), wanted_.end(), [&](std::int64_t block) {
          return !blocks_.contains(block);
        });
        return found == wanted_.end() ? std::nullopt : std::optional(*found);
      };
      if (!changed_.wait(lock, stop, [&] { return (next = missing()).has_value(); })) return {};
    }
    Block block(kBlock);
    const auto decoded = read_exactly(reader, static_cast<std::uint64_t>(*next * kBlock), block);
    if (!decoded) {
      // Where the file is damaged there is silence, and then it goes on.
      if (decoded.error().code != ErrorCode::invalid) return decoded;
      if (!std::exchange(damaged, true)) on_error_(decoded.error());
      reader = TRY(OpusReader::open(read, file_.bytes));
    }
    const std::lock_guard lock(mutex_);
    // Those that are wanted take no more than kMostBlocks.
    std::erase_if(blocks_, [&](const auto& entry) {
      return blocks_.size() >= kMostBlocks &&
             std::find(wanted_.begin(), wanted_.end(), entry.first) == wanted_.end();
    });
    blocks_[*next] = std::move(block);
  }
}

}  // namespace pointreel
