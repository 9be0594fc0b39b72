#pragma once

#include "common/command_line/command.h"
#include "common/http/http_options.h"

namespace pointreel {

/// How commands ask servers and stores: they wait longer than a player, and give up at last.
HttpOptions patient_http_options();

/// --endpoint and --ca-file.
void add_store_options(cli::Command command, HttpOptions& options);

}  // namespace pointreel
