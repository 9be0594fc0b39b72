#include "client/source/http_folder.h"

#include "common/base/try.h"
#include "common/net/url.h"
#include "common/stream/manifest.h"

namespace pointreel {

std::string HttpFolder::manifest() const { return file(kManifestName); }

Result<HttpFolder> parse_http_folder(const std::string& url) {
  TRY(parse_url(url));
  HttpFolder folder{url.substr(0, url.find('#')), {}};
  if (const std::size_t query = folder.base.find('?'); query != std::string::npos) {
    folder.query = folder.base.substr(query);
    folder.base.resize(query);
  }
  if (const std::string tail = std::string("/") + kManifestName; folder.base.ends_with(tail))
    folder.base.resize(folder.base.size() - tail.size());
  while (folder.base.ends_with('/')) folder.base.pop_back();
  return folder;
}

}  // namespace pointreel
