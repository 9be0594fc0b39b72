#include "client/web/wasm/errors.h"

#include <string>

namespace pointreel {
namespace {

std::string text;
PrError code = PR_OK;

static_assert(static_cast<int>(ErrorCode::invalid) + 1 == PR_INVALID &&
              static_cast<int>(ErrorCode::unsupported) + 1 == PR_UNSUPPORTED &&
              static_cast<int>(ErrorCode::limit) + 1 == PR_LIMIT &&
              static_cast<int>(ErrorCode::argument) + 1 == PR_ARGUMENT &&
              static_cast<int>(ErrorCode::not_found) + 1 == PR_NOT_FOUND &&
              static_cast<int>(ErrorCode::io) + 1 == PR_IO &&
              static_cast<int>(ErrorCode::cancelled) + 1 == PR_CANCELLED);

}  // namespace

PrError report(const Error& error) {
  text = error.message;
  code = static_cast<PrError>(static_cast<int>(error.code) + 1);
  return code;
}

}  // namespace pointreel

const char* pr_error_text() { return pointreel::text.c_str(); }
PrError pr_error_code() { return pointreel::code; }
