#pragma once

#include "pointreel/error.h"

namespace pointreel {

/// The code of an error that is an HTTP status other than success.
constexpr ErrorCode code_of_status(long status) {
  switch (status) {
    case 404:
      return ErrorCode::not_found;
    case 408:  // what may pass
    case 425:
    case 429:
    case 416:  // about the file, not the client
      return ErrorCode::io;
    default:
      return status >= 400 && status < 500 ? ErrorCode::refused : ErrorCode::io;
  }
}

}  // namespace pointreel
