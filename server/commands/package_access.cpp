#include "server/commands/package_access.h"

#include "common/command_line/token_option.h"

namespace pointreel {

void PackageAccess::add_to(cli::Command command) {
  add_store_options(command, http_);
  token_ = command.add_option("--token", http_.token, "the token that the server asks viewers for")
               .envname("POINTREEL_TOKEN")
               .type_name("TOKEN");
}

Result<PackageFiles> PackageAccess::open(const std::string& where,
                                         const std::stop_token& stop) const {
  if (std::string fault = fault_of_token(token_); !fault.empty())
    return fail(ErrorCode::argument, std::move(fault));
  HttpOptions options = http_;
  options.stop = stop;
  return PackageFiles::at(where, options);
}

}  // namespace pointreel
