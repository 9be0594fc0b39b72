#include "server/service/access.h"

#include <openssl/crypto.h>
#include <openssl/sha.h>
#include <strings.h>

namespace pointreel {

Access::Digest Access::digest(std::string_view token) {
  Digest digest{};
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), digest.data());
  return digest;
}

Access::Access(std::string_view view_token, std::string_view publish_token) {
  if (!view_token.empty()) view_ = digest(view_token);
  if (!publish_token.empty()) publish_ = digest(publish_token);
}

Access::Verdict Access::check(Right right, std::string_view authorization, bool nearby) const {
  const std::optional<Digest>& wanted = right == Right::kView ? view_ : publish_;
  if (!wanted) {
    return right == Right::kView || nearby ? Verdict::kGranted : Verdict::kOnlyNearby;
  }
  static constexpr std::string_view kScheme = "Bearer ";
  if (authorization.size() < kScheme.size() ||
      ::strncasecmp(authorization.data(), kScheme.data(), kScheme.size()) != 0) {
    return Verdict::kNoToken;
  }
  std::string_view token = authorization.substr(kScheme.size());
  while (token.starts_with(' ')) token.remove_prefix(1);
  while (token.ends_with(' ') || token.ends_with('\t')) token.remove_suffix(1);
  const Digest given = digest(token);
  const bool same = CRYPTO_memcmp(given.data(), wanted->data(), given.size()) == 0;
  return same ? Verdict::kGranted : Verdict::kNoToken;
}

}  // namespace pointreel
