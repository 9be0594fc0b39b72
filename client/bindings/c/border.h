#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <type_traits>

#include "client/bindings/c/pointreel.h"
#include "common/base/try.h"
#include "pointreel/error.h"

/// What stands between C and C++: statuses and messages, structs of another version, text.
namespace pointreel {

/// Keeps the error's message for the calling thread.
pointreel_status failed(const Error& error) noexcept;
pointreel_status failed(pointreel_status status, const char* message) noexcept;

/// Runs `work`, which returns a Result<void> or a Result<pointreel_status>, and lets no exception
/// out.
template <class Work>
pointreel_status guarded(const Work& work) noexcept {
  try {
    const auto result = work();
    if (!result) return failed(result.error());
    if constexpr (!std::is_void_v<typename std::remove_cvref_t<decltype(result)>::value_type>)
      return *result;
    return POINTREEL_OK;
  } catch (const std::bad_alloc&) {
    return failed(POINTREEL_LIMIT, "out of memory");
  } catch (const std::exception& exception) {
    return failed(POINTREEL_INTERNAL, exception.what());
  } catch (...) {
    return failed(POINTREEL_INTERNAL, "an unknown exception");
  }
}

/// No struct of any version is larger.
inline constexpr std::size_t kMostStructBytes = 1024;

Result<void> check_struct_size(std::size_t size, const char* name);
/// Whether the bytes of a struct beyond those that this version knows are 0.
Result<void> check_unknown_members(const void* at, std::size_t known, std::size_t size,
                                   const char* name);

/// The caller's options, with 0 for members that its version does not have. `name`: the struct's.
template <class Options>
Result<Options> options_of(const Options* given, const char* name) {
  Options options;
  std::memset(&options, 0, sizeof options);
  if (given == nullptr) return options;
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  TRY(check_struct_size(size, name));
  TRY(check_unknown_members(given, sizeof options, size, name));
  std::memcpy(&options, given, std::min(size, sizeof options));
  return options;
}

/// Fills the members that the caller's version has.
template <class Info>
Result<void> give(Info info, Info* to, const char* name) {
  if (to == nullptr) return fail(ErrorCode::argument, std::string(name) + " is NULL");
  std::size_t size = 0;
  std::memcpy(&size, to, sizeof size);
  TRY(check_struct_size(size, name));
  info.struct_size = size;
  std::memcpy(to, &info, std::min(size, sizeof info));
  return {};
}

/// Copies text to the caller's room for it, with a 0 at its end.
Result<void> give_text(const std::string& text, char* to, std::size_t capacity,
                       std::size_t* length);

}  // namespace pointreel
