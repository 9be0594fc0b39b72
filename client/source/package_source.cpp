#include "client/source/package_source.h"

#include <utility>

#include "common/base/try.h"

namespace pointreel {

Error no_package(const Error& error) {
  if (error.code == ErrorCode::unsupported) return error;
  return {error.message + "; give the folder or address of a package", error.code};
}

PackageSource::PackageSource(Manifest manifest, std::shared_ptr<const ContextTables> tables)
    : manifest_(std::move(manifest)), tables_(std::move(tables)) {}

Result<FetchedFrame> PackageSource::fetch(const FetchRequest& request) {
  const auto ranges = TRY(ranges_of(manifest_, request.frame, request.layers));
  std::vector<FileRange> wanted;
  for (const FileRange& range : ranges)
    if (total(range.sizes) > 0) wanted.push_back(range);
  auto bytes = TRY(read(wanted, request));
  FetchedFrame fetched;
  fetched.tables = tables_;
  auto next = bytes.begin();
  for (const FileRange& range : ranges)
    fetched.layers.push_back({total(range.sizes) > 0 ? std::move(*next++) : Bytes{}, range.sizes});
  return fetched;
}

}  // namespace pointreel
