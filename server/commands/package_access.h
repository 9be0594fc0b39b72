#pragma once

#include <stop_token>
#include <string>

#include "common/command_line/command.h"
#include "common/http/http_options.h"
#include "pointreel/error.h"
#include "server/commands/store_options.h"
#include "server/store/package_files.h"

namespace pointreel {

/// How a command reads packages from servers and object stores.
class PackageAccess {
 public:
  /// --endpoint, --ca-file and --token.
  void add_to(cli::Command command);

  /// `where`: a folder, or an address. Errors: as PackageFiles::at, and `argument` for a token that
  /// is empty.
  Result<PackageFiles> open(const std::string& where, const std::stop_token& stop = {}) const;

 private:
  HttpOptions http_ = patient_http_options();
  cli::Option token_;
};

}  // namespace pointreel
