#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "pointreel/error.h"
#include "server/store/upload.h"

/// What `upload` and `pack --to` print.
namespace pointreel {

Result<UploadSummary> upload_with_progress(Uploader& uploader,
                                           const std::filesystem::path& package);

std::string upload_text(const std::string& to, const UploadSummary& summary);
nlohmann::ordered_json upload_json(const std::string& to, const UploadSummary& summary);

}  // namespace pointreel
