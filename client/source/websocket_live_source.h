#pragma once

#include <memory>
#include <string>

#include "client/source/live_source.h"

namespace pointreel {

/// A live stream that a server sends as it is published: ws://HOST/live/NAME or
/// wss://HOST/live/NAME.
Result<std::unique_ptr<LiveSource>> open_websocket_live_source(const std::string& url,
                                                               const SourceOptions& options);

}  // namespace pointreel
