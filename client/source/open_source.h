#pragma once

#include <memory>
#include <string>

#include "client/source/source.h"

namespace pointreel {

/// Opens what `where` names: the http:// or https:// address of a package, a package's folder or
/// its reel.json, or a folder of files of points or one such file.
Result<std::unique_ptr<Source>> open_source(const std::string& where,
                                            const SourceOptions& options = {});

/// `not_found` if `where` names a file or folder that is not there. Addresses are not looked at.
Result<void> check_is_there(const std::string& where);

}  // namespace pointreel
