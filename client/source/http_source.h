#pragma once

#include <memory>
#include <string>

#include "client/source/source.h"

namespace pointreel {

/// A package on any HTTP server that supports Range requests. `url` names its folder or its
/// reel.json.
Result<std::unique_ptr<Source>> open_http_source(const std::string& url,
                                                 const SourceOptions& options);

}  // namespace pointreel
