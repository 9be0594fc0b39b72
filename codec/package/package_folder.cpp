#include "codec/package/package_folder.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <sys/types.h>

#include "codec/core/scalar_fields.h"
#include "codec/octree/octree_codec.h"
#include "codec/package/manifest.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

void drop_unused_layers(const fs::path& folder, Manifest& manifest) {
  const auto unused = [](const Segment& segment) { return segment.layers.back().bytes == 0; };
  while (manifest.layer_names.size() > 1 &&
         std::all_of(manifest.segments.begin(), manifest.segments.end(), unused)) {
    for (Segment& segment : manifest.segments) {
      std::error_code ignored;
      fs::remove(folder / segment.layers.back().path, ignored);
      segment.layers.pop_back();
    }
    manifest.layer_names.pop_back();
  }
}

/// In reels of shallow octrees, scalar fields are in a layer that was meant for finer levels.
void name_scalar_layer(Manifest& manifest) {
  const int depth = static_cast<int>(manifest.depth_max);
  const auto geometry = static_cast<std::size_t>(layer_count(depth));
  if (manifest.scalars.empty() || manifest.layer_names.size() != geometry + 1) return;
  manifest.layer_names.pop_back();
  add_scalar_layer(manifest.layer_names);
}

/// The process that writes a file of this name, which is NAME.PID~ until it is whole
/// (write_file.h).
std::optional<pid_t> writer_of(std::string_view name) {
  if (!name.ends_with('~')) return std::nullopt;
  name.remove_suffix(1);
  const std::size_t dot = name.rfind('.');
  if (dot == name.npos) return std::nullopt;
  pid_t pid = 0;
  const auto [end, error] = std::from_chars(name.data() + dot + 1, name.data() + name.size(), pid);
  if (error != std::errc() || end != name.data() + name.size() || pid <= 0) return std::nullopt;
  return pid;
}

/// Whether it is the name of a reel's sound: audio, eight hexadecimal digits, opus.
bool is_sound(std::string_view name) {
  constexpr std::string_view kBegin = "audio.", kEnd = ".opus";
  return name.size() == kBegin.size() + 8 + kEnd.size() && name.starts_with(kBegin) &&
         name.ends_with(kEnd) &&
         name.substr(kBegin.size(), 8).find_first_not_of("0123456789abcdef") == name.npos;
}

}  // namespace

std::string reel_name(const std::string& given, const fs::path& output) {
  if (!given.empty()) return given;
  const fs::path normal = fs::absolute(output).lexically_normal();
  const fs::path last = normal.has_filename() ? normal.filename() : normal.parent_path().filename();
  return visible(last.extension() == ".reel" ? last.stem().string() : last.string());
}

Result<void> may_replace_package(const fs::path& folder) {
  const Result<Manifest> manifest = read_manifest(folder);
  if (!manifest && manifest.error().code == ErrorCode::not_found) {
    return fail(ErrorCode::argument,
                "is not a package, and only packages are replaced; remove it first");
  }
  if (!manifest) {
    return fail(ErrorCode::argument,
                fmt::format("nobody knows which files belong to it, because {} is damaged; remove "
                            "it first",
                            kManifestName));
  }
  std::set<std::string> parts = {kManifestName, kJournalName};
  for (const PackageFile* file : manifest->files()) parts.insert(file->path);
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    // What a program that was killed has left may go, too.
    if (const auto writer = writer_of(name)) {
      if (::kill(*writer, 0) == 0 || errno == EPERM)
        return fail(ErrorCode::argument,
                    fmt::format("process {} is writing to it; wait until it ends", *writer));
      continue;
    }
    if (!parts.contains(name) && !is_sound(name)) {
      return fail(ErrorCode::argument,
                  fmt::format("holds {}, which is not part of the package; remove it first", name));
    }
  }
  if (error) return fail(ErrorCode::io, error.message());
  return {};
}

Result<std::uint64_t> finish_package(const fs::path& folder, Manifest& manifest,
                                     const fs::path& shown) {
  drop_unused_layers(folder, manifest);
  name_scalar_layer(manifest);
  return write_package_manifest(folder, manifest, shown);
}

Result<std::uint64_t> write_package_manifest(const fs::path& folder, const Manifest& manifest,
                                             const fs::path& shown) {
  const std::string text = write_manifest(manifest);
  if (text.size() > kMaxManifestBytes) {
    return fail(
        ErrorCode::limit,
        fmt::format("{}: {} would have {} bytes, and readers take at most {}; make packages "
                    "of fewer frames",
                    shown.string(), kManifestName, text.size(), kMaxManifestBytes));
  }
  if (const auto parsed = parse_manifest(text); !parsed) {
    return fail_at("the package would not be valid", parsed.error());
  }
  TRY(write_file(folder / kManifestName, text));
  return text.size();
}

}  // namespace pointreel
