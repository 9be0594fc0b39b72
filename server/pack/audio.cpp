#include "server/pack/audio.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include "codec/audio/opus_reader.h"
#include "codec/audio/sound_file.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/descriptor.h"
#include "common/file_system/lock_folder.h"
#include "common/file_system/open_file.h"
#include "common/file_system/output_folder.h"
#include "common/file_system/write_file.h"
#include "common/process/ffmpeg.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> arguments(const fs::path& source, std::uint64_t duration_us) {
  std::vector<std::string> all = sound_input(source);
  all.insert(all.end(),
             {"-map", "0:a:0", "-map_metadata", "-1",
              // Sound that begins after the picture of a video stays there.
              "-af", fmt::format("aresample={}:async=1:first_pts=0", kAudioRate), "-ac", "2", "-t",
              fmt::format("{}us", duration_us), "-c:a", "libopus", "-b:a", "128k",
              // The same bytes for the same sound.
              "-fflags", "+bitexact", "-flags:a", "+bitexact", "-f", "ogg", "pipe:1"});
  return all;
}

/// What comes from a pipe until its end, no longer than a package may have sound.
Result<Bytes> read_all(int pipe, const std::stop_token& stop) {
  Bytes bytes;
  std::vector<std::uint8_t> part(1 << 16);
  for (;;) {
    pollfd ready{pipe, POLLIN, 0};
    const int polled = poll(&ready, 1, 100);
    if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
    if (polled == 0 || (polled < 0 && errno == EINTR)) continue;
    const ssize_t size = read(pipe, part.data(), part.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return fail(ErrorCode::io, std::strerror(errno));
    if (size == 0) return bytes;
    bytes.insert(bytes.end(), part.begin(), part.begin() + size);
    if (bytes.size() > kMaxAudioBytes)
      return fail(ErrorCode::limit, fmt::format("takes more than {} bytes", kMaxAudioBytes));
  }
}

struct Encoded {
  Bytes bytes;
  std::string said;  ///< by ffmpeg, in one line; empty if it found nothing wrong
};

Result<Encoded> encode(const fs::path& source, std::uint64_t duration_us,
                       const std::stop_token& stop) {
  std::array<int, 2> ends{-1, -1};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return fail(ErrorCode::io, std::strerror(errno));
  const Descriptor output(ends[0]);
  Descriptor input(ends[1]);
  Ffmpeg ffmpeg = TRY(Ffmpeg::start(arguments(source, duration_us), {.output = input.get()}));
  input.close();
  Bytes bytes = TRY(read_all(output.get(), stop));
  const bool ended_well = ffmpeg.wait();
  std::string said = ffmpeg.reason();
  if (!ended_well) return tl::unexpected(unreadable_sound(said));
  return Encoded{std::move(bytes), std::move(said)};
}

struct EncodedSound {
  EncodedAudio audio;
  Bytes bytes;
};

Result<EncodedSound> encode_sound(const fs::path& source, std::uint64_t duration_us,
                                  const std::stop_token& stop, const OnWarning& warn) {
  TRY(check_audio_source(source));
  const SoundEnd end = TRY(at_place(source.string(), find_sound_end(source, duration_us)));
  auto encoded = encode(source, duration_us, stop);
  if (!encoded && encoded.error().code == ErrorCode::cancelled)
    return tl::unexpected(encoded.error());
  auto [bytes, said] = TRY(at_place(source.string(), std::move(encoded)));
  EncodedAudio audio;
  audio.cut_off = end.end_us > duration_us + end.slack_us;
  audio.source_us = end.whole_us;
  AudioFile& file = audio.file;
  file.samples = TRY(at_place(source.string(), OpusReader::open(bytes))).samples();
  TRY(at_place(source.string(),
               end.check(file.samples * 1'000'000 / kAudioRate, duration_us, said)));
  if (!said.empty() && warn) warn(fmt::format("{}: {}", source.string(), said));
  file.bytes = bytes.size();
  file.checksum = checksum_of(bytes);
  file.path = fmt::format("audio.{:08x}.opus", file.checksum >> 32);
  return EncodedSound{std::move(audio), std::move(bytes)};
}

/// Locks a package against programs that replace it, if it still has this manifest.
Result<Descriptor> lock_package(const fs::path& package, const Manifest& manifest) {
  std::error_code error;
  Descriptor lock(lock_folder(fs::canonical(package, error), LOCK_NB));
  if (lock.get() < 0 && errno == EWOULDBLOCK)
    return fail(ErrorCode::io,
                package.string() + ": another program is writing to it; try again later");
  // Without a lock, on a file system that has none, this is what can be done.
  if (write_manifest(TRY(read_manifest(package))) != write_manifest(manifest))
    return fail(ErrorCode::io, package.string() +
                                   ": another program has changed it meanwhile; its sound stays "
                                   "as it is now");
  return lock;
}

}  // namespace

void warn_of_unpacked_audio(const std::vector<fs::path>& inputs,
                            std::vector<std::string>& warnings) {
  for (const fs::path& input : inputs) {
    const fs::path sound = input / kUnpackedAudio;
    std::error_code ignored;
    if (fs::is_regular_file(sound, ignored))
      warnings.push_back(sound.string() + ": not packed; add it with --audio");
  }
}

Result<void> check_audio_source(const fs::path& source) {
  if (!is_installed("ffmpeg")) return fail(ErrorCode::not_found, kSoundNeedsFfmpeg);
  std::error_code error;
  if (!fs::is_regular_file(source, error) || access(source.c_str(), R_OK) != 0)
    return fail(ErrorCode::not_found, source.string() + ": is not a file that can be read");
  return {};
}

std::string encoded_audio_text(const EncodedAudio& audio) {
  const auto seconds = [](double value) { return number_text(value, 3) + " s"; };
  std::string text = seconds(static_cast<double>(audio.file.samples) / kAudioRate);
  if (!audio.cut_off) return text;
  if (audio.source_us) text += " of " + seconds(1e-6 * static_cast<double>(*audio.source_us));
  return text + " (the rest was cut off)";
}

Result<EncodedAudio> write_audio(const fs::path& source, const fs::path& folder,
                                 std::uint64_t duration_us, const std::stop_token& stop,
                                 const OnWarning& warn) {
  const EncodedSound sound = TRY(encode_sound(source, duration_us, stop, warn));
  TRY(replace_file(folder / sound.audio.file.path, sound.bytes));
  return sound.audio;
}

Result<std::optional<AudioFile>> replace_audio(const fs::path& package,
                                               const std::optional<fs::path>& source,
                                               const std::stop_token& stop, const OnWarning& warn) {
  const Manifest old = TRY(read_manifest(package));
  if (old.live)
    return fail(ErrorCode::argument,
                package.string() + ": is a recording that has not ended; wait for its end");
  Manifest manifest = old;
  manifest.audio.reset();
  EncodedSound sound;
  if (source) {
    sound = TRY(encode_sound(*source, manifest.duration_us, stop, warn));
    manifest.audio = sound.audio.file;
  }
  const std::string text = write_manifest(manifest);
  TRY(at_place("the package would not be valid", parse_manifest(text)));
  const Descriptor lock = TRY(lock_package(package, old));
  if (source) TRY(replace_file(package / sound.audio.file.path, sound.bytes));
  std::error_code error;
  const std::optional<AudioFile>& before = old.audio;
  if (const auto replaced = replace_file(package / kManifestName, text); !replaced) {
    if (manifest.audio && (!before || before->path != manifest.audio->path))
      fs::remove(package / manifest.audio->path, error);
    return tl::unexpected(replaced.error());
  }
  // What the journal held is in the manifest now. Nothing is lost if it, or the old file, stays.
  fs::remove(package / kJournalName, error);
  if (before && (!manifest.audio || before->path != manifest.audio->path))
    fs::remove(package / before->path, error);
  return manifest.audio;
}

Result<void> check_audio(const PackageFiles& files, const AudioFile& audio) {
  std::ifstream file = TRY(open_stream(TRY(files.local(audio))));
  OpusReader reader = TRY(OpusReader::open(OpusReader::read_at(file), audio.bytes));
  std::vector<StereoSample> block(kAudioRate);
  std::uint64_t samples = 0;
  for (;;) {
    const OpusReader::Read read = TRY(reader.read(block));
    if (read.hole) return fail(fmt::format("is damaged after {}", counted(samples, "sample")));
    if (read.samples == 0) break;
    samples += read.samples;
  }
  if (samples == audio.samples) return {};
  return fail(fmt::format("decodes to {}, the manifest says {}", counted(samples, "sample"),
                          audio.samples));
}

}  // namespace pointreel
