#include "client/source/open_live_source.h"

#include "client/source/http_live_source.h"
#include "client/source/websocket_live_source.h"
#include "common/base/try.h"
#include "common/net/url.h"

namespace pointreel {

Result<std::unique_ptr<LiveSource>> open_live_source(const std::string& url,
                                                     const SourceOptions& options) {
  TRY(check_token(options.token));
  const Url parsed = TRY(parse_url(url));
  if (parsed.is_websocket()) return open_websocket_live_source(url, options);
  if (parsed.is_http()) return open_http_live_source(url, options);
  return fail(ErrorCode::argument,
              without_secrets(url) + ": is not a live stream; give ws://HOST/live/NAME");
}

}  // namespace pointreel
