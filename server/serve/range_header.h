#pragma once

#include <cstdint>
#include <string_view>

/// The Range header field of RFC 9110, section 14.2, for one resource of known size.
namespace pointreel {

struct RangeAnswer {
  enum class Kind {
    kWhole,          ///< no range, one that is malformed, or several: answer 200 with everything
    kPart,           ///< answer 206 with `offset` and `size`; size > 0
    kUnsatisfiable,  ///< answer 416
  };
  Kind kind = Kind::kWhole;
  std::uint64_t offset = 0, size = 0;  ///< bytes; for kPart
  bool operator==(const RangeAnswer&) const = default;
};

/// What to send of a resource of `size` bytes. `field` is untrusted: the value of the header
/// field, empty if there is none. A server may ignore ranges it does not like, and must ignore
/// malformed ones, so several ranges in one request get the whole resource.
RangeAnswer answer_range(std::string_view field, std::uint64_t size);

}  // namespace pointreel
