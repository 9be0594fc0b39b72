#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pointreel {

/// Bearer tokens (RFC 6750): who may view and who may publish. The rights are apart: a token for
/// one does not give the other.
///
/// Trust: credentials are untrusted and bounded by the head of a request. They are compared by
/// their SHA-256 in constant time, so that neither a token's length nor its beginning shows.
class Access {
 public:
  enum class Right { kView, kPublish };
  enum class Verdict {
    kGranted,
    kNoToken,     ///< 401: a token is needed, and none came or a wrong one
    kOnlyNearby,  ///< 403: there is no token for this, and without one only this machine may
  };

  /// Empty: without a token everybody may view, and only who is on this machine may publish.
  Access(std::string_view view_token, std::string_view publish_token);

  /// `authorization`: the field's value, empty if there is none. `nearby`: the peer is on this
  /// machine, and speaks for itself.
  Verdict check(Right right, std::string_view authorization, bool nearby) const;
  /// Whether what is viewed may be kept by caches that others use.
  bool viewing_is_public() const { return !view_; }

 private:
  using Digest = std::array<std::uint8_t, 32>;
  static Digest digest(std::string_view token);
  std::optional<Digest> view_, publish_;
};

}  // namespace pointreel
