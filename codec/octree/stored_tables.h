#pragma once

#include "pointreel/bytes.h"

namespace pointreel {

/// The file tables/1.zst. It is part of the library (stored_tables.cpp), except in a browser, where
/// it is loaded beside the WebAssembly module (client/web/wasm/tables.cpp).
ByteView stored_tables();

}  // namespace pointreel
