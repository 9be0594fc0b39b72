#pragma once

#include <filesystem>

namespace pointreel {

/// The folder of this repository.
std::filesystem::path source_folder();

/// The folder where the build puts programs, and libraries that tests load into them.
std::filesystem::path program_folder();

}  // namespace pointreel
