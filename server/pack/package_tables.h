#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_options.h"
#include "pointreel/error.h"
#include "pointreel/package.h"
#include "server/pack/packer.h"

namespace pointreel {

/// What learn_package_tables found.
struct PackageTables {
  LearntTables learnt;
  std::optional<PackageFile> file;  ///< absent if tables would save nothing
};

/// Learns context tables from some of the frames, writes them to `folder` if that makes the package
/// smaller, and then sets them in the options. Runs in the calling arena. The codec must be the
/// octree codec with Entropy::context. Errors name the file at fault, or the output.
Result<PackageTables> learn_package_tables(std::span<const CloudFrame> files, PackOptions& options,
                                           const std::filesystem::path& folder,
                                           const std::stop_token& stop);

}  // namespace pointreel
