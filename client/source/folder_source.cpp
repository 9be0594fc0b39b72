#include "client/source/folder_source.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "codec/cloud_file.h"

namespace pointreel {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{4} << 30;

class FolderSource : public Source {
 public:
  FolderSource(std::vector<std::filesystem::path> files, Manifest manifest)
      : files_(std::move(files)), manifest_(std::move(manifest)) {}

  const Manifest& manifest() const override { return manifest_; }

  Result<FetchedFrame> fetch(std::uint32_t frame, const FetchRequest&) override {
    const std::filesystem::path& path = files_[frame];
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in)
      return fail(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
    const std::streamoff size = in.tellg();
    if (size < 0 || static_cast<std::uint64_t>(size) > kMaxFileBytes)
      return fail(path.string() + ": is no plain file of at most 4 GiB");
    FetchedFrame fetched;
    fetched.file_name = path.string();
    fetched.file.resize(static_cast<std::size_t>(size));
    in.seekg(0);
    in.read(reinterpret_cast<char*>(fetched.file.data()), size);
    if (in.gcount() != size) return fail(path.string() + ": cannot be read to its end");
    return fetched;
  }

 private:
  const std::vector<std::filesystem::path> files_;
  const Manifest manifest_;
};

std::string name_of(const std::filesystem::path& path) {
  return path.filename().empty() ? path.parent_path().filename().string()
                                 : path.filename().string();
}

}  // namespace

Result<std::unique_ptr<Source>> open_folder_source(const std::filesystem::path& path,
                                                   const SourceOptions& options) {
  auto files = list_cloud_files({path});
  if (!files) return tl::unexpected(files.error());

  Manifest manifest;
  manifest.name = name_of(path);
  manifest.codec = "files";
  manifest.fps = options.fps;
  manifest.up = options.up;
  const auto time_of = [&](std::size_t frame) {
    return static_cast<std::uint64_t>(std::llround(1e6 * static_cast<double>(frame) / options.fps));
  };
  manifest.duration_us = time_of(files->size());

  std::optional<Error> first_error;
  bool found = false;
  for (const std::filesystem::path& file : *files) {
    const auto loaded = read_cloud_file(file);
    if (!loaded) {
      if (!first_error) first_error = loaded.error();
      continue;
    }
    found = true;
    manifest.bounds = bounds(loaded->cloud);
    manifest.colors = loaded->cloud.has_colors();
    manifest.normals = loaded->cloud.has_normals();
    if (!loaded->cloud.empty()) break;
  }
  if (!found) return tl::unexpected(*first_error);

  Segment segment;
  segment.cube = bounding_cube(manifest.bounds);
  for (std::size_t i = 0; i < files->size(); ++i) segment.times_us.push_back(time_of(i));
  segment.points.assign(files->size(), 0);
  manifest.segments.push_back(std::move(segment));
  return std::make_unique<FolderSource>(std::move(*files), std::move(manifest));
}

}  // namespace pointreel
