#include "client/source/open_live_source.h"

#include "client/source/http_live_source.h"
#include "client/source/websocket_live_source.h"

namespace pointreel {

Result<std::unique_ptr<LiveSource>> open_live_source(const std::string& url,
                                                     const SourceOptions& options) {
  if (url.starts_with("ws://") || url.starts_with("wss://"))
    return open_websocket_live_source(url, options);
  if (url.starts_with("http://") || url.starts_with("https://"))
    return open_http_live_source(url, options);
  return fail(url + ": is no live stream; give ws://HOST/live/NAME");
}

}  // namespace pointreel
