#include "client/bindings/c/border.h"

#include <array>
#include <atomic>

#include "client/bindings/c/handles.h"
#include "common/base/concat.h"
#include "common/base/hide_secrets.h"
#include "common/process/print.h"

namespace pointreel {
namespace {

/// Of the calling thread. It has no destructor, so that threads may end in any order.
thread_local std::array<char, 1024> message{};

pointreel_status status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid:
      return POINTREEL_INVALID;
    case ErrorCode::unsupported:
      return POINTREEL_UNSUPPORTED;
    case ErrorCode::limit:
      return POINTREEL_LIMIT;
    case ErrorCode::argument:
      return POINTREEL_ARGUMENT;
    case ErrorCode::not_found:
      return POINTREEL_NOT_FOUND;
    case ErrorCode::io:
      return POINTREEL_IO;
    case ErrorCode::cancelled:
      return POINTREEL_CANCELLED;
    case ErrorCode::refused:
      return POINTREEL_REFUSED;
  }
  return POINTREEL_INTERNAL;
}

}  // namespace

std::uintptr_t next_handle() {
  static std::atomic<std::uintptr_t> last{0};
  return ++last;
}

pointreel_status failed(pointreel_status status, const char* text) noexcept {
  const std::size_t length = std::min(std::strlen(text), message.size() - 1);
  std::memcpy(message.data(), text, length);
  message[length] = '\0';
  return status;
}

pointreel_status failed(const Error& error) noexcept {
  const pointreel_status status = status_of(error.code);
  try {
    return failed(status, visible(hide_secrets(error.message)).c_str());
  } catch (...) {
    return failed(status, "out of memory");
  }
}

Result<void> check_struct_size(std::size_t size, const char* name) {
  if (size >= sizeof(std::size_t) && size <= kMostStructBytes) return {};
  return fail(ErrorCode::argument,
              concat("struct_size of ", name, " is ", size, "; set it to sizeof the struct"));
}

Result<void> check_unknown_members(const void* at, std::size_t known, std::size_t size,
                                   const char* name) {
  const auto* bytes = static_cast<const unsigned char*>(at);
  for (std::size_t i = known; i < size; ++i)
    if (bytes[i] != 0)
      return fail(ErrorCode::unsupported,
                  concat(name, " has a member that this version does not know"));
  return {};
}

Result<void> give_text(const std::string& text, char* to, std::size_t capacity,
                       std::size_t* length) {
  if (length != nullptr) *length = text.size();
  if (to == nullptr && capacity == 0) {
    if (length == nullptr) return fail(ErrorCode::argument, "neither room nor length is given");
    return {};
  }
  if (to == nullptr) return fail(ErrorCode::argument, "the room for the text is NULL");
  if (capacity <= text.size())
    return fail(ErrorCode::limit,
                concat("the text takes ", text.size() + 1, " bytes, not ", capacity));
  std::memcpy(to, text.c_str(), text.size() + 1);
  return {};
}

}  // namespace pointreel

const char* pointreel_error_message(void) { return pointreel::message.data(); }
