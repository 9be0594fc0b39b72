#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include "pointreel/error.h"

namespace pointreel {

/// The value of a Result that holds no error; void for a Result<void>.
template <class AnyResult>
auto value_of_result(AnyResult&& result) {
  if constexpr (!std::is_void_v<typename std::remove_cvref_t<AnyResult>::value_type>)
    return *std::forward<AnyResult>(result);
}

/// The same result, with an error that names the place: "place: message".
template <class T>
Result<T> at_place(const std::string& place, Result<T> result) {
  if (!result) return fail_at(place, result.error());
  return result;
}

}  // namespace pointreel

/// The value of a Result. If the Result holds an error, the enclosing function returns that error.
///
///   const PointCloud cloud = TRY(read_ply(bytes));
///   TRY(write_ply(path, cloud));  // a Result<void>
///
/// This is a statement expression, an extension of g++ and clang.
// clang-format off
#define TRY(...)                                                                               \
  ({                                                                                           \
    _Pragma("GCC diagnostic push")                                                             \
    _Pragma("GCC diagnostic ignored \"-Wshadow\"")                                             \
    auto&& try_result = (__VA_ARGS__);                                                         \
    _Pragma("GCC diagnostic pop")                                                              \
    if (!try_result) {                                                                         \
      return ::tl::unexpected<::pointreel::Error>(                                             \
          std::forward<decltype(try_result)>(try_result).error());                             \
    }                                                                                          \
    ::pointreel::value_of_result(std::forward<decltype(try_result)>(try_result));              \
  })
// clang-format on
