#pragma once

#include <span>

#include "server/service/page.h"

namespace pointreel {

/// The files of the page that were built into this program; none if it was built without. No room
/// knows them, because the page takes minutes to build.
std::span<const PageFile> built_in_page();

}  // namespace pointreel
