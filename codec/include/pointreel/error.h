#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace pointreel {

/// What kind of failure it was. Callers decide by the code; messages are for people and may change
/// from version to version.
enum class ErrorCode : std::uint8_t {
  invalid,      ///< the input is damaged, or breaks the rules of its format
  unsupported,  ///< the input is of a newer format version, or needs a part that was not built
  limit,        ///< the input asks for more than a format or the caller allows
  argument,     ///< the caller passed a value out of range
  not_found,    ///< there is no such file, reel, frame or stream
  io,           ///< the file system, the network or a device failed
  cancelled,    ///< the caller asked to stop
  refused,      ///< the server will not do this for this client, for instance without a token
};

/// Why an operation failed. The message is one line for a person, without a full stop: it says what
/// is wrong, where, and, unless it is obvious, what to do about it.
struct Error {
  std::string message;
  ErrorCode code = ErrorCode::invalid;
};

/// A value, or the error that prevented it. No interface of Pointreel throws.
template <class T>
using Result = tl::expected<T, Error>;

/// `return fail(...)` works in every function that returns a Result.
inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{std::move(message), code});
}
inline tl::unexpected<Error> fail(std::string message) {
  return fail(ErrorCode::invalid, std::move(message));
}

/// The same error as the caller sees it: "place: message".
inline tl::unexpected<Error> fail_at(const std::string& place, const Error& error) {
  return fail(error.code, place + ": " + error.message);
}

/// "invalid", "unsupported", "limit", "argument", "not_found", "io", "cancelled",
/// "refused".
const char* name(ErrorCode code);

}  // namespace pointreel
