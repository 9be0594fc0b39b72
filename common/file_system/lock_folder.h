#pragma once

#include <filesystem>

namespace pointreel {

/// Takes the lock of a folder, which whoever changes or replaces it holds, for as long as the
/// descriptor is open. `wait`: LOCK_NB, or 0 to wait for it. -1, and errno says why, if another
/// program has it (EWOULDBLOCK), if the folder has gone (ENOENT) or another has come in its place
/// meanwhile (ESTALE), or on file systems without locks.
int lock_folder(const std::filesystem::path& folder, int wait);

/// Whether this is still the folder that a descriptor was opened for.
bool is_still(int descriptor, const std::filesystem::path& folder);

}  // namespace pointreel
