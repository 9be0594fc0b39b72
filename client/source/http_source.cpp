#include "client/source/http_source.h"

#include <functional>
#include <utility>

#include "client/source/package_source.h"
#include "client/source/whole_files.h"
#include "codec/package/http_folder.h"
#include "common/base/try.h"
#include "common/http/http_client.h"
#include "common/net/url.h"

namespace pointreel {
namespace {

class HttpSource : public PackageSource {
 public:
  HttpSource(HttpFolder folder, std::unique_ptr<HttpClient> client, Manifest manifest,
             std::shared_ptr<const ContextTables> tables,
             std::function<void(const std::string&)> say)
      : PackageSource(std::move(manifest), std::move(tables)),
        folder_(std::move(folder)),
        client_(std::move(client)),
        files_(*client_, std::move(say)) {}

  Result<Bytes> fetch_audio(std::uint64_t offset, std::uint64_t size,
                            const std::stop_token& stop) override {
    const AudioFile& file = *manifest().audio;
    const HttpClient::Range range{folder_.file(file.path), offset, size, file.bytes};
    std::vector<Bytes> bytes = TRY(files_.get_ranges({&range, 1}, stop));
    return std::move(bytes.front());
  }

  void cancel() override { client_->cancel(); }
  std::optional<std::string> trouble() const override { return client_->trouble(); }
  LinkUse link_use() const override { return client_->link_use(); }

 private:
  Result<std::vector<Bytes>> read(std::span<const FileRange> ranges,
                                  const FetchRequest& request) override {
    std::vector<HttpClient::Range> wanted;
    for (const FileRange& range : ranges)
      wanted.push_back(
          {folder_.file(range.file->path), range.offset, range.bytes(), range.file->bytes});
    return files_.get_ranges(wanted, request.stop, request.fresh);
  }

  const HttpFolder folder_;
  const std::unique_ptr<HttpClient> client_;
  WholeFiles files_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_http_source(const std::string& url,
                                                 const SourceOptions& options) {
  HttpFolder folder = TRY(resolve_folder(url, options.endpoint));
  const std::string manifest_url = folder.manifest();

  auto client = std::make_unique<HttpClient>(options, folder.access);
  const auto text = client->get(manifest_url, kMaxManifestBytes);
  if (!text) {
    const bool found = text.error().code != ErrorCode::not_found;
    return tl::unexpected(found ? text.error() : no_package(text.error()));
  }
  auto manifest = parse_manifest({reinterpret_cast<const char*>(text->data()), text->size()});
  if (!manifest)
    return tl::unexpected(no_package(
        {without_secrets(manifest_url) + ": " + manifest.error().message, manifest.error().code}));
  std::shared_ptr<const ContextTables> tables;
  if (manifest->tables) {
    const std::string tables_url = folder.file(manifest->tables->path);
    const Bytes bytes = TRY(client->get(tables_url, manifest->tables->bytes));
    auto read = read_tables(*manifest->tables, bytes);
    if (!read) return fail_at(without_secrets(tables_url), read.error());
    tables = std::move(*read);
  }
  return std::make_unique<HttpSource>(std::move(folder), std::move(client), *std::move(manifest),
                                      std::move(tables), options.say);
}

}  // namespace pointreel
