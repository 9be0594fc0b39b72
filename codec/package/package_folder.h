#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "pointreel/error.h"
#include "pointreel/package.h"

/// The folder that a package is written to.
namespace pointreel {

/// The name that a reel was given or, if that is empty, that of its folder, without ".reel".
std::string reel_name(const std::string& given, const std::filesystem::path& output);

/// OutputFolder::MayReplace for packages: those are replaced, but nothing else that someone may
/// have put there.
Result<void> may_replace_package(const std::filesystem::path& folder);

/// Completes the package whose layer files are in `folder`: writes its manifest. Shallow octrees do
/// not have the finest layers; layers that no frame has are removed. Returns the size of reel.json.
/// Errors begin with `shown`, the folder's final place.
Result<std::uint64_t> finish_package(const std::filesystem::path& folder, Manifest& manifest,
                                     const std::filesystem::path& shown);

/// The same for a manifest that stays as it is. Error `limit` if it gets too long.
Result<std::uint64_t> write_package_manifest(const std::filesystem::path& folder,
                                             const Manifest& manifest,
                                             const std::filesystem::path& shown);

}  // namespace pointreel
