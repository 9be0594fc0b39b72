#include "server/relay/recorded_package.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/file_system/lock_folder.h"
#include "common/file_system/open_file.h"
#include "common/file_system/write_file.h"
#include "server/relay/left_sound.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// A manifest up to this length is rewritten for each segment.
constexpr std::size_t kShortManifest = 16u << 10;
/// A longer one is rewritten when the journal has reached this share of its length.
constexpr std::size_t kJournalShare = 8;
/// Readers ignore a file of this name.
constexpr const char *kUnfinished = ".unfinished", *kGrowingSound = ".sound";

Error cannot_write(const fs::path& file) {
  return {fmt::format("{}: cannot be written: {}", file.string(), why_not_written(errno)),
          ErrorCode::io};
}

/// Writes all bytes; errno tells why not.
bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Result<void> write_file(const fs::path& folder, const std::string& name, std::string_view content) {
  const fs::path unfinished = folder / kUnfinished, file = folder / name;
  const int out = ::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (out < 0) return tl::unexpected(cannot_write(file));
  bool written = write_all(out, content);
  written = ::close(out) == 0 && written;
  if (written && ::rename(unfinished.c_str(), file.c_str()) == 0) return {};
  const Error error = cannot_write(file);
  ::unlink(unfinished.c_str());  // it would take room that may be needed
  return tl::unexpected(error);
}

/// Writes a file of sound, as the manifest names it.
Result<AudioFile> write_audio(const fs::path& folder, ByteView bytes, std::uint64_t samples) {
  AudioFile audio;
  audio.samples = samples;
  audio.bytes = bytes.size();
  audio.checksum = checksum_of(bytes);
  audio.path = fmt::format("audio.{:08x}.opus", audio.checksum >> 32);
  TRY(write_file(folder, audio.path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  return audio;
}

std::uint64_t checksum_of_text(std::string_view text) {
  return checksum_of(ByteView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace

RecordedPackage::RecordedPackage(fs::path folder, std::uint32_t first_frame, std::uint64_t start_us)
    : folder_(std::move(folder)),
      first_frame_(first_frame),
      start_us_(start_us),
      lock_(lock_folder(folder_, LOCK_NB)),
      sound_(folder_ / kGrowingSound, start_us) {}

Result<void> RecordedPackage::add(LiveSegment& segment, const LiveHello& hello) {
  const Segment as_it_was = segment.entry;
  segment.entry = rebased(std::move(segment.entry), 0, start_us_);
  segment.entry.first_frame = frames_;  // there may be a gap before it
  name_files(segment, hello.layer_names);
  const auto undo = [&] {
    for (const LayerFile& file : segment.entry.layers) ::unlink((folder_ / file.path).c_str());
    segment.entry = as_it_was;
  };
  for (std::size_t i = 0; i < segment.files.size(); ++i) {
    if (auto written = write_file(folder_, segment.entry.layers[i].path, segment.files[i]);
        !written) {
      undo();
      return written;
    }
  }
  const LiveTotals totals = totals_;
  const std::uint64_t duration_us = duration_us_;
  totals_.add(segment);
  duration_us_ = end_of(segment.entry, hello.fps);
  lines_.push_back(write_segment(segment.entry));
  Manifest manifest = head(hello);
  manifest.live = LiveManifest{hello.session, first_frame_, start_us_, false};
  const std::string line = write_journal_line(manifest, lines_.back());

  const bool rewrite = written_bytes_ <= kShortManifest ||
                       journal_bytes_ + line.size() > written_bytes_ / kJournalShare;
  Result<void> written = fail(ErrorCode::io, "");
  if (rewrite) written = write_manifest_file(manifest);
  // A full disk may still have room for a line.
  if (!written && written_bytes_ > 0) written = append_to_journal(line);
  if (!written) {
    totals_ = totals;
    duration_us_ = duration_us;
    lines_.pop_back();
    undo();
    return written;
  }
  frames_ += segment.entry.frame_count();
  lines_bytes_ += lines_.back().size();
  complete_ = false;
  return {};
}

Result<void> RecordedPackage::complete(const LiveHello& hello) {
  if (complete_) lock_.close();
  if (complete_ || empty()) return {};
  const std::optional<AudioFile> before = audio_;
  // Pictures without sound are better than neither.
  const Result<void> sound = write_sound();
  TRY(write_manifest_file(head(hello)));
  if (before && before->path != audio_->path) ::unlink((folder_ / before->path).c_str());
  complete_ = sound.has_value();
  if (complete_) lock_.close();
  return sound;
}

Result<void> RecordedPackage::write_sound() {
  if (sound_.samples() == 0 || (audio_ && audio_->samples == sound_.samples())) return {};
  const Bytes bytes = TRY(sound_.bytes());
  audio_ = TRY(write_audio(folder_, bytes, sound_.samples()));
  return {};
}

void RecordedPackage::remove() const { ::rmdir(folder_.c_str()); }

bool RecordedPackage::take_back() {
  std::error_code ignored;
  if (!fs::is_directory(folder_, ignored)) return false;
  if (lock_.get() >= 0) return is_still(lock_.get(), folder_);
  if (!complete_) return true;
  Descriptor lock(lock_folder(folder_, LOCK_NB));
  if (lock.get() < 0 && errno == EWOULDBLOCK) return false;
  const auto text = read_text(folder_ / kManifestName, kMaxManifestBytes);
  if (!text || checksum_of_text(*text) != written_checksum_) return false;
  if (sound_.samples() > 0 && !fs::exists(folder_ / kGrowingSound, ignored)) return false;
  lock_ = std::move(lock);
  return true;
}

Manifest RecordedPackage::head(const LiveHello& hello) const {
  Manifest manifest = live_head(hello, totals_);
  manifest.duration_us = duration_us_;
  manifest.captured_us = start_us_;
  manifest.audio = audio_;
  return manifest;
}

Result<void> RecordedPackage::write_manifest_file(const Manifest& head) {
  const std::string text = write_manifest(head, lines_);
  TRY(write_file(folder_, kManifestName, text));
  written_bytes_ = text.size();
  written_checksum_ = checksum_of_text(text);
  // What it holds is in the manifest now. Readers know by the frames' numbers, if it remains.
  ::unlink((folder_ / kJournalName).c_str());
  journal_bytes_ = 0;
  return {};
}

Result<void> RecordedPackage::append_to_journal(const std::string& line) {
  const fs::path file = folder_ / kJournalName;
  const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (out < 0) return tl::unexpected(cannot_write(file));
  const auto before = static_cast<off_t>(journal_bytes_);
  const bool written = ::lseek(out, before, SEEK_SET) == before && write_all(out, line);
  const Error error = cannot_write(file);
  // A line that is cut off must not precede others.
  if (!written && ::ftruncate(out, before) != 0) written_bytes_ = 0;
  ::close(out);
  if (!written) return tl::unexpected(error);
  journal_bytes_ += line.size();
  return {};
}

namespace {

/// Puts the sound that was growing into the manifest, unless that has as much.
Result<void> add_left_sound(const fs::path& folder, Manifest& manifest) {
  const fs::path file = folder / kGrowingSound;
  std::error_code none;
  const std::uintmax_t size = fs::file_size(file, none);
  if (none) return {};
  std::ifstream in(file, std::ios::binary);
  Bytes bytes(std::min<std::uintmax_t>(size, LiveSoundFile::kMostBytes));
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  const LeftSound left = find_left_sound(bytes);
  if (left.samples == 0 || (manifest.audio && manifest.audio->samples >= left.samples)) return {};
  manifest.audio = TRY(write_audio(folder, ByteView(bytes).first(left.bytes), left.samples));
  return {};
}

/// All that a killed program left of a recording becomes its manifest.
Result<void> complete_recording(const fs::path& folder) {
  Manifest manifest = TRY(read_manifest(folder));
  manifest.live.reset();
  const std::optional<AudioFile> before = manifest.audio;
  // Pictures without sound are better than neither.
  const Result<void> sound = add_left_sound(folder, manifest);
  TRY(write_file(folder, kManifestName, write_manifest(manifest)));
  ::unlink((folder / kJournalName).c_str());
  if (before && before->path != manifest.audio->path) ::unlink((folder / before->path).c_str());
  if (sound) ::unlink((folder / kGrowingSound).c_str());
  return sound;
}

}  // namespace

void complete_recordings(const fs::path& folder,
                         const std::function<void(const std::string& line)>& say) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    const auto has = [&](const char* name) {
      return fs::is_regular_file(entry.path() / name, ignored);
    };
    if (!has(kJournalName) && !has(kGrowingSound)) continue;
    const Descriptor lock(lock_folder(entry.path(), LOCK_NB));
    if (lock.get() < 0) continue;
    if (const auto completed = complete_recording(entry.path()); !completed && say)
      say(completed.error().message);
  }
}

}  // namespace pointreel
