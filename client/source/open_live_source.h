#pragma once

#include <memory>
#include <string>

#include "client/source/live_source.h"

namespace pointreel {

/// Opens ws(s)://HOST/live/NAME, or http(s)://HOST/live/NAME/reel.json where caches pass the stream
/// on. Only a malformed address is an error: a server that does not answer yet is waited for.
Result<std::unique_ptr<LiveSource>> open_live_source(const std::string& url,
                                                     const SourceOptions& options);

}  // namespace pointreel
