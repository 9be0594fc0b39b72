#include "client/source/package_source.h"

#include <utility>

#include "common/base/try.h"

namespace pointreel {
namespace {

/// Groups of video that are kept besides what the player keeps: those of a few threads.
constexpr std::size_t kKeptGroups = 4;

}  // namespace

Error no_package(const Error& error) {
  if (error.code == ErrorCode::unsupported) return error;
  return {error.message + "; give the folder or address of a package", error.code};
}

PackageSource::PackageSource(Manifest manifest, std::shared_ptr<const ContextTables> tables)
    : manifest_(std::move(manifest)), tables_(std::move(tables)) {}

std::shared_ptr<const FetchedGroup> PackageSource::known_group(const FileRange& range) {
  const std::lock_guard lock(mutex_);
  for (const Group& group : groups_)
    if (group.file == range.file && group.offset == range.offset) return group.fetched;
  return nullptr;
}

std::shared_ptr<const FetchedGroup> PackageSource::keep_group(const FileRange& range, Bytes bytes) {
  auto fetched = std::make_shared<const FetchedGroup>(
      FetchedGroup{std::move(bytes), {range.group.begin(), range.group.end()}});
  const std::lock_guard lock(mutex_);
  groups_.push_front({range.file, range.offset, fetched});
  if (groups_.size() > kKeptGroups) groups_.pop_back();
  return fetched;
}

Result<FetchedFrame> PackageSource::fetch(const FetchRequest& request) {
  const auto ranges = TRY(ranges_of(manifest_, request.frame, request.layers));
  std::vector<FileRange> wanted;
  std::vector<std::shared_ptr<const FetchedGroup>> groups;
  for (const FileRange& range : ranges) {
    groups.push_back(range.group.empty() || request.fresh ? nullptr : known_group(range));
    if (range.bytes() > 0 && !groups.back()) wanted.push_back(range);
  }
  auto bytes = TRY(read(wanted, request));
  FetchedFrame fetched;
  fetched.tables = tables_;
  auto next = bytes.begin();
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const FileRange& range = ranges[i];
    if (range.group.empty()) {
      fetched.layers.push_back({range.bytes() > 0 ? std::move(*next++) : Bytes{}, range.sizes});
      continue;
    }
    const auto group =
        groups[i] ? groups[i] : keep_group(range, range.bytes() > 0 ? std::move(*next++) : Bytes{});
    std::uint64_t offset = 0;
    for (const Chunks<std::uint32_t>& before : range.group.first(range.index))
      offset += total(before);
    fetched.layers.push_back(
        {group->bytes.part(offset, total(range.sizes)), range.sizes, group, range.index});
  }
  return fetched;
}

}  // namespace pointreel
