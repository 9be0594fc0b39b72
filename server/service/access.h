#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pointreel {

/// Decides by bearer tokens (RFC 6750) who may view and who may publish. The two rights are
/// separate: a token for one does not give the other.
///
/// Trust: credentials are untrusted. Their size is bounded by the head of a request. They are
/// compared by their SHA-256 in constant time, so that timing reveals neither the length nor the
/// beginning of a token.
class Access {
 public:
  enum class Right { kView, kPublish };
  enum class Verdict {
    kGranted,
    kNoToken,     ///< 401: a token is required, and none or a wrong one was given
    kOnlyNearby,  ///< 403: no token is configured for this, so only this machine may do it
  };

  /// Without a view token (empty) everybody may view. Without a publish token only programs on this
  /// machine may publish.
  Access(std::string_view view_token, std::string_view publish_token);

  /// `authorization` is the value of that header field, empty if there is none. `nearby` says that
  /// the peer is on this machine and acts on its own behalf.
  Verdict check(Right right, std::string_view authorization, bool nearby) const;
  /// Whether shared caches may keep what is served to viewers.
  bool viewing_is_public() const { return !view_; }

 private:
  using Digest = std::array<std::uint8_t, 32>;
  static Digest digest(std::string_view token);
  std::optional<Digest> view_, publish_;
};

}  // namespace pointreel
