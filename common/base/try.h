#pragma once

#include <type_traits>
#include <utility>

#include "pointreel/error.h"

namespace pointreel {

/// The value of a Result that holds one; nothing for a Result<void>.
template <class AnyResult>
auto value_of_result(AnyResult&& result) {
  if constexpr (!std::is_void_v<typename std::remove_cvref_t<AnyResult>::value_type>)
    return *std::forward<AnyResult>(result);
}

}  // namespace pointreel

/// The value of a Result. If it holds an error, the function that this stands in returns the error.
///
///   const PointCloud cloud = TRY(read_ply(bytes));
///   TRY(write_ply(path, cloud));  // a Result<void>
///
/// This is a statement expression, an extension that g++ and clang share.
#define TRY(...)                                                                                \
  ({                                                                                            \
    _Pragma("GCC diagnostic push") _Pragma("GCC diagnostic ignored \"-Wshadow\"") auto&&        \
        try_result = (__VA_ARGS__);                                                             \
    _Pragma("GCC diagnostic pop") if (!try_result) return ::tl::unexpected<::pointreel::Error>( \
        std::forward<decltype(try_result)>(try_result).error());                                \
    ::pointreel::value_of_result(std::forward<decltype(try_result)>(try_result));               \
  })
