#pragma once

#include <memory>
#include <string>

#include "client/source/source.h"

namespace pointreel {

/// A package on any HTTP server, or in an object store: resolve_folder says which addresses there
/// are. Servers that support no Range requests send whole files (WholeFiles).
Result<std::unique_ptr<Source>> open_http_source(const std::string& url,
                                                 const SourceOptions& options);

}  // namespace pointreel
