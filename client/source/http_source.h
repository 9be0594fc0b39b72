#pragma once

#include <memory>
#include <string>

#include "client/source/source.h"

namespace pointreel {

/// A package on any HTTP server that supports Range requests, or in an object store: resolve_folder
/// says which addresses there are.
Result<std::unique_ptr<Source>> open_http_source(const std::string& url,
                                                 const SourceOptions& options);

}  // namespace pointreel
