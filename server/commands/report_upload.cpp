#include "server/commands/report_upload.h"

#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/base/words.h"
#include "common/process/progress.h"

namespace pointreel {

Result<UploadSummary> upload_with_progress(Uploader& uploader,
                                           const std::filesystem::path& package) {
  std::unique_ptr<Progress> progress;
  UploadListener listener;
  listener.begin = [&](std::size_t files) {
    progress = std::make_unique<Progress>("upload", files);
  };
  listener.file_done = [&] { progress->tick(); };
  return uploader.upload(package, listener);
}

std::string upload_text(const std::string& to, const UploadSummary& summary) {
  std::string text = fmt::format("{}: {}, {} sent", to, counted(summary.files, "file"),
                                 counted(summary.bytes, "byte"));
  if (summary.kept > 0)
    text += fmt::format("; {} {} there already", counted(summary.kept, "file"),
                        summary.kept == 1 ? "was" : "were");
  if (summary.growing) text += "; the recording still grows; --follow uploads the rest, too";
  return text;
}

nlohmann::ordered_json upload_json(const std::string& to, const UploadSummary& summary) {
  return {{"to", to},
          {"files", summary.files},
          {"bytes", summary.bytes},
          {"kept_files", summary.kept},
          {"growing", summary.growing}};
}

}  // namespace pointreel
