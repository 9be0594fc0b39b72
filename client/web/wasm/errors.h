#pragma once

#include "client/web/wasm/module.h"
#include "pointreel/error.h"

namespace pointreel {

/// Keeps the error for pr_error_text and pr_error_code, and returns its number.
PrError report(const Error& error);

}  // namespace pointreel
