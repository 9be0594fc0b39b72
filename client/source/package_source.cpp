#include "client/source/package_source.h"

#include <utility>

namespace pointreel {

PackageSource::PackageSource(Manifest manifest, std::shared_ptr<const ContextTables> tables)
    : manifest_(std::move(manifest)), tables_(std::move(tables)) {}

Result<FetchedFrame> PackageSource::fetch(std::uint32_t frame, const FetchRequest& request) {
  const auto ranges = ranges_of(manifest_, frame, request);
  if (!ranges) return tl::unexpected(ranges.error());
  std::vector<LayerRange> wanted;
  for (const LayerRange& range : *ranges)
    if (range.sizes.total() > 0) wanted.push_back(range);
  auto bytes = read(wanted, request);
  if (!bytes) return tl::unexpected(bytes.error());
  FetchedFrame fetched;
  fetched.tables = tables_;
  auto next = bytes->begin();
  for (const LayerRange& range : *ranges)
    fetched.layers.push_back({range.sizes.total() > 0 ? std::move(*next++) : Bytes{}, range.sizes});
  return fetched;
}

}  // namespace pointreel
