#pragma once

/// The version of the library and the programs. CMakeLists.txt reads it from here.
#define POINTREEL_VERSION "0.1.0"
