#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "server/service/page.h"

namespace pointreel {

struct WrittenPage {
  std::size_t packages = 0;
  std::vector<std::string> faults;  ///< of packages that are not listed
};

/// Writes the page's files into a folder that holds packages, and reels.json, the list of them: for
/// web servers that serve files and nothing else. Replaces what an earlier call has written there;
/// an index.html or a reels.json of somebody else is an error, unless `force` is set.
Result<WrittenPage> write_page(const std::filesystem::path& folder, std::span<const PageFile> page,
                               bool force);

}  // namespace pointreel
