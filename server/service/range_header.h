#pragma once

#include <cstdint>
#include <string_view>

/// The Range header field of RFC 9110, section 14.2, for one resource of known size.
namespace pointreel {

struct RangeAnswer {
  enum class Kind {
    kWhole,          ///< no range, a malformed one, or several: answer 200 with everything
    kPart,           ///< answer 206 with `offset` and `size`; size > 0
    kUnsatisfiable,  ///< answer 416
  };
  Kind kind = Kind::kWhole;
  std::uint64_t offset = 0, size = 0;  ///< in bytes, for kPart
  bool operator==(const RangeAnswer&) const = default;
};

/// Which part of a resource of `size` bytes to send. `field` is the untrusted value of the header
/// field, empty if there is none. A server may ignore the field, and must do so if it is malformed.
/// Several ranges in one request get the whole resource.
RangeAnswer answer_range(std::string_view field, std::uint64_t size);

}  // namespace pointreel
