#include "server/relay/session.h"

#include <openssl/sha.h>

namespace pointreel {

SessionProof proof_of(const LiveSecret& secret) {
  SessionProof proof{};
  SHA256(secret.data(), secret.size(), proof.data());
  return proof;
}

SessionProofs proofs_of(const LiveIdentity& identity) {
  SessionProofs proofs{proof_of(identity.secret)};
  if (identity.earlier) proofs.earlier = proof_of(*identity.earlier);
  return proofs;
}

std::uint64_t session_of(const SessionProof& proof) {
  std::uint64_t session = 0;
  for (std::size_t i = 0; i < sizeof(session); ++i) session = session << 8 | proof[i];
  return session;
}

SessionProof proof_of_session(std::uint64_t session) {
  SessionProof proof{};
  for (std::size_t i = 0; i < sizeof(session); ++i)
    proof[i] = static_cast<std::uint8_t>(session >> (56 - 8 * i));
  return proof;
}

}  // namespace pointreel
