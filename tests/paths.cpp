#include "tests/paths.h"

namespace pointreel {

std::filesystem::path source_folder() { return POINTREEL_SOURCE_DIR; }

std::filesystem::path program_folder() { return POINTREEL_BIN_DIR; }

}  // namespace pointreel
