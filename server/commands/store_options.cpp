#include "server/commands/store_options.h"

namespace pointreel {

HttpOptions patient_http_options() {
  HttpOptions options;
  options.connect_timeout = std::chrono::seconds(10);
  options.stall_timeout = std::chrono::seconds(10);
  options.first_backoff = std::chrono::milliseconds(250);
  options.max_backoff = std::chrono::seconds(4);
  options.open_attempts = options.fetch_attempts = 6;
  return options;
}

void add_store_options(cli::Command command, HttpOptions& options) {
  command
      .add_option("--endpoint", options.endpoint,
                  "the object store that s3:// means, such as http://127.0.0.1:9000 (default: "
                  "AWS_ENDPOINT_URL, or Amazon's); its keys are read from the environment or from "
                  "~/.aws, as Amazon's programs do")
      .type_name("URL");
  command
      .add_option("--ca-file", options.ca_file,
                  "certificates to trust for https:// instead of the system's, in PEM form")
      .check(cli::existing_file())
      .type_name("FILE");
}

}  // namespace pointreel
