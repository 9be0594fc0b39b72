#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace pointreel {

/// Why an operation failed: one line for a person, without a full stop, that says what is wrong,
/// where, and what to do about it where that is not obvious.
struct Error {
  std::string message;
};

/// A value or the error that kept it from being made. Nothing in Pointreel's own interfaces throws.
template <class T>
using Result = tl::expected<T, Error>;

/// `return fail("...");` from any function that returns a Result.
inline tl::unexpected<Error> fail(std::string message) {
  return tl::unexpected<Error>(Error{std::move(message)});
}

/// `error` as seen from further out: "place: message".
inline tl::unexpected<Error> fail_at(const std::string& place, const Error& error) {
  return tl::unexpected<Error>(Error{place + ": " + error.message});
}

}  // namespace pointreel
