#include "client/web/wasm/errors.h"

#include <string>

namespace pointreel {
namespace {

std::string last_text;
PrError last_code = PR_OK;

static_assert(static_cast<int>(ErrorCode::invalid) + 1 == PR_INVALID &&
              static_cast<int>(ErrorCode::unsupported) + 1 == PR_UNSUPPORTED &&
              static_cast<int>(ErrorCode::limit) + 1 == PR_LIMIT &&
              static_cast<int>(ErrorCode::argument) + 1 == PR_ARGUMENT &&
              static_cast<int>(ErrorCode::not_found) + 1 == PR_NOT_FOUND &&
              static_cast<int>(ErrorCode::io) + 1 == PR_IO &&
              static_cast<int>(ErrorCode::cancelled) + 1 == PR_CANCELLED &&
              static_cast<int>(ErrorCode::refused) + 1 == PR_REFUSED);

}  // namespace

PrError report(const Error& error) {
  last_text = error.message;
  last_code = static_cast<PrError>(static_cast<int>(error.code) + 1);
  return last_code;
}

}  // namespace pointreel

const char* pr_error_text() { return pointreel::last_text.c_str(); }
PrError pr_error_code() { return pointreel::last_code; }
