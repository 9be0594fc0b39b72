#include "client/source/http_source.h"

#include <string_view>
#include <utility>

#include "client/source/http_client.h"

namespace pointreel {
namespace {

class HttpSource : public Source {
 public:
  HttpSource(std::string base, std::unique_ptr<HttpClient> client, Manifest manifest,
             std::shared_ptr<const ContextTables> tables)
      : base_(std::move(base)),
        client_(std::move(client)),
        manifest_(std::move(manifest)),
        tables_(std::move(tables)) {}

  const Manifest& manifest() const override { return manifest_; }

  Result<FetchedFrame> fetch(std::uint32_t frame, const FetchRequest& request) override {
    const auto ranges = ranges_of(manifest_, frame, request);
    if (!ranges) return tl::unexpected(ranges.error());
    FetchedFrame fetched;
    fetched.tables = tables_;
    for (const LayerRange& range : *ranges) {
      FetchedLayer layer{{}, range.sizes};
      if (range.sizes.total() > 0) {
        const std::string url = base_ + "/" + range.file->path;
        auto bytes = client_->get_range(url, range.offset, range.sizes.total(), range.file->bytes);
        if (!bytes) return fail_at(url, bytes.error());
        layer.bytes = std::move(*bytes);
      }
      fetched.layers.push_back(std::move(layer));
    }
    return fetched;
  }

  void cancel() override { client_->cancel(); }

 private:
  const std::string base_;
  const std::unique_ptr<HttpClient> client_;
  const Manifest manifest_;
  const std::shared_ptr<const ContextTables> tables_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_http_source(const std::string& url,
                                                 const SourceOptions& options) {
  std::string base = url;
  if (const std::string tail = std::string("/") + kManifestName; base.ends_with(tail))
    base.resize(base.size() - tail.size());
  while (base.ends_with('/')) base.pop_back();
  if (base.ends_with(':')) return fail(url + ": names no host");
  const std::string manifest_url = base + "/" + kManifestName;

  auto client = std::make_unique<HttpClient>(options);
  const auto text = client->get(manifest_url, kMaxManifestBytes);
  if (!text) return fail_at(manifest_url, text.error());
  auto manifest = parse_manifest({reinterpret_cast<const char*>(text->data()), text->size()});
  if (!manifest) return fail_at(manifest_url, manifest.error());
  std::shared_ptr<const ContextTables> tables;
  if (manifest->tables) {
    const std::string tables_url = base + "/" + manifest->tables->path;
    const auto bytes = client->get(tables_url, manifest->tables->bytes);
    if (!bytes) return fail_at(tables_url, bytes.error());
    auto read = read_tables(*manifest->tables, *bytes);
    if (!read) return fail_at(tables_url, read.error());
    tables = std::move(*read);
  }
  return std::make_unique<HttpSource>(std::move(base), std::move(client), std::move(*manifest),
                                      std::move(tables));
}

}  // namespace pointreel
