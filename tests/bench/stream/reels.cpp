#include "tests/bench/stream/reels.h"

#include <chrono>
#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "client/prepare/prepare.h"
#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "pointreel/package.h"
#include "tests/bench/program.h"
#include "tests/e2e/server_address.h"

namespace pointreel::bench {
namespace {

namespace fs = std::filesystem;

template <class T>
std::uint64_t checksum_of_values(const std::vector<T>& values) {
  return checksum_of(
      {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)});
}

/// Makes a package that shows the frames of another `times` times, with hard links to its files.
Result<void> lengthen(const fs::path& packed, const fs::path& longer, std::uint32_t times) {
  Manifest manifest = TRY(read_manifest(packed));
  fs::create_directories(longer);
  if (manifest.tables)
    fs::create_hard_link(packed / manifest.tables->path, longer / manifest.tables->path);
  const std::vector<Segment> once = std::exchange(manifest.segments, {});
  const std::uint64_t duration_us = manifest.duration_us;
  std::uint32_t frame = 0;
  for (std::uint32_t pass = 0; pass < times; ++pass) {
    for (Segment segment : once) {
      segment.first_frame = frame;
      frame += segment.frame_count();
      for (std::uint64_t& time : segment.times_us) time += pass * duration_us;
      for (LayerFile& file : segment.layers) {
        const std::string path = fmt::format("{}.{}", pass, file.path);
        fs::create_hard_link(packed / file.path, longer / path);
        file.path = path;
      }
      manifest.segments.push_back(std::move(segment));
    }
  }
  manifest.duration_us = duration_us * times;
  std::ofstream out(longer / kManifestName, std::ios::binary);
  if (!(out << write_manifest(manifest))) {
    return fail(ErrorCode::io, (longer / kManifestName).string() + ": cannot be written");
  }
  return {};
}

Result<std::uint64_t> content(Source& source, std::uint32_t frame, std::uint32_t layers) {
  const auto fetched = source.fetch({frame, {.end = layers}});
  if (!fetched) return tl::unexpected(fetched.error());
  const auto scene =
      prepare_frame(*fetched, frame_info(source.manifest(), frame), {DrawMode::surfel});
  if (!scene) return tl::unexpected(scene.error());
  return content_of(*scene);
}

Result<StreamedReel> make_reel(const fs::path& scratch, const std::string& name,
                               std::vector<std::string> synth, std::uint32_t frames,
                               std::uint32_t times, int slabs = 1) {
  StreamedReel reel;
  reel.name = name;
  reel.folder = scratch / name;
  reel.packed = scratch / (name + "-once");
  const fs::path packed = reel.packed, clouds = scratch / (name + "-clouds");
  if (!fs::exists(reel.folder)) {
    synth.insert(synth.end(), {"-o", clouds.string(), "--frames", std::to_string(frames)});
    TRY(run_program("pointreel-synth", synth));
    TRY(run_program("pointreel-server",
                    {"pack", "-i", clouds, "-o", packed, "--slabs", std::to_string(slabs)}));
    fs::remove_all(clouds);
    TRY(lengthen(packed, reel.folder, times));
  }
  const auto source = TRY(open_source(packed.string()));
  const Manifest& manifest = source->manifest();
  reel.packed_frames = manifest.frame_count();
  reel.frames = reel.packed_frames * times;
  std::uint64_t bytes = 0;
  for (const PackageFile* file : manifest.files()) bytes += file->bytes;
  reel.bits_per_second =
      8e6 * static_cast<double>(bytes) / static_cast<double>(manifest.duration_us);
  for (std::uint32_t frame = 0; frame < reel.packed_frames; ++frame) {
    reel.whole.push_back(TRY(content(*source, frame, ~0u)));
    reel.base.push_back(TRY(content(*source, frame, 1)));
  }
  return reel;
}

std::vector<std::string> serve_arguments(const std::vector<StreamedReel>& reels) {
  std::vector<std::string> arguments = {"serve", "--listen", "127.0.0.1:0"};
  for (const StreamedReel& reel : reels) arguments.push_back(reel.folder.string());
  return arguments;
}

}  // namespace

std::uint64_t content_of(const SceneFrame& frame) {
  return checksum_of_values(frame.svo.masks) ^ 3 * checksum_of_values(frame.attributes.colors);
}

Result<std::vector<StreamedReel>> streamed_reels(const StreamOptions& options) {
  const fs::path scratch = options.scratch / "reels";
  std::error_code ignored;
  fs::create_directories(scratch, ignored);
  const bool quick = options.quick;
  StreamedReel shoot =
      TRY(make_reel(scratch, "soccer-shoot", {"soccer-shoot"}, quick ? 12 : 60, quick ? 75 : 15));
  StreamedReel dense = TRY(make_reel(scratch, "dense", {"kick", "--voxelize", "10"}, quick ? 4 : 20,
                                     quick ? 225 : 45, 2));
  return std::vector<StreamedReel>{std::move(shoot), std::move(dense)};
}

NamedLink megabits(std::uint64_t rate) {
  LinkConditions conditions;
  conditions.bits_per_second = rate * 1'000'000;
  conditions.delay = std::chrono::milliseconds(10);
  return {fmt::format("{} Mbit/s, 20 ms", rate), conditions};
}

ServedReels::ServedReels(std::vector<StreamedReel> reels)
    : reels_(std::move(reels)),
      process_("pointreel-server", serve_arguments(reels_)),
      address_(e2e::server_address(process_)) {}

Result<std::unique_ptr<ServedReels>> ServedReels::start(const StreamOptions& options) {
  std::unique_ptr<ServedReels> served(new ServedReels(TRY(streamed_reels(options))));
  if (served->address_.empty()) return fail(ErrorCode::io, "pointreel-server: did not start");
  return served;
}

Result<std::unique_ptr<LinkEmulator>> ServedReels::link(const NamedLink& link) const {
  return LinkEmulator::start({.target = address_, .conditions = link.conditions});
}

std::string ServedReels::url(const StreamedReel& reel) const {
  return "http://" + address_ + "/" + reel.name;
}

std::string ServedReels::url(const LinkEmulator& link, const StreamedReel& reel) {
  return "http://" + link.address() + "/" + reel.name;
}

}  // namespace pointreel::bench
