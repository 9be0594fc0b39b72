#pragma once

#include <memory>
#include <string>

#include "client/source/source.h"

namespace pointreel {

/// Opens what `where` names: the http:// or https:// address of a package, a package's folder or
/// its reel.json, or a folder of files of points or one such file.
Result<std::unique_ptr<Source>> open_source(const std::string& where,
                                            const SourceOptions& options = {});

}  // namespace pointreel
