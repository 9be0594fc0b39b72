#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/process/progress.h"
#include "common/process/stop_signal.h"
#include "server/commands/commands.h"
#include "server/commands/report_upload.h"
#include "server/commands/store_options.h"
#include "server/store/upload.h"

namespace pointreel {
namespace {

struct UploadArguments {
  std::string reel;
  UploadOptions options;
  bool json = false;
};

int run_upload(UploadArguments arguments) {
  const StopSignal stop;
  UploadOptions& options = arguments.options;
  options.http.stop = stop.token();
  auto uploader = Uploader::open(options);
  const auto summary = uploader ? upload_with_progress(*uploader, arguments.reel)
                                : Result<UploadSummary>(tl::unexpected(uploader.error()));
  if (!summary) return failed_to_open(summary.error());
  if (arguments.json) {
    print_json(upload_json(options.to, *summary));
  } else {
    print("{}\n", upload_text(options.to, *summary));
  }
  return kExitOk;
}

}  // namespace

void add_upload_command(cli::Command app, int& exit_code) {
  const auto a = std::make_shared<UploadArguments>();
  a->options.http = patient_http_options();
  const cli::Command command = app.add_subcommand(
      "upload",
      "Upload a package into an object store that speaks S3\n"
      "Players read it from there. What is there already is not sent again, so an upload that was "
      "interrupted goes on.");
  command.add_option("REEL", a->reel, "the folder of the package").required().type_name("");
  command.add_option("TO", a->options.to, "where to: s3://BUCKET/REEL").required().type_name("");
  add_store_options(command, a->options.http);
  command.add_flag("--follow", a->options.follow,
                   "keep uploading what a growing recording adds, until it ends");
  command.add_flag("--force", a->options.force,
                   "replace another reel that is there, or send again what is missing or "
                   "differs of this one");
  command.add_flag("--json", a->json, "print the summary as JSON");
  command.callback([a, &exit_code] { exit_code = run_upload(*a); });
}

}  // namespace pointreel
