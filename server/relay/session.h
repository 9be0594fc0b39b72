#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "codec/live/live.h"

namespace pointreel {

/// What the server keeps of a publisher's secret: its SHA-256. It recognises the publisher, but
/// nobody can find the secret from it.
using SessionProof = std::array<std::uint8_t, 32>;
SessionProof proof_of(const LiveSecret& secret);

/// The same of a LiveIdentity.
struct SessionProofs {
  SessionProof proof{};
  std::optional<SessionProof> earlier = {};
};
SessionProofs proofs_of(const LiveIdentity& identity);

/// The session as viewers see it: the first 64 bits of the proof. It is the same after the server
/// was started again.
std::uint64_t session_of(const SessionProof& proof);

/// What stands for the proof of a session that another server passes on: the session, and zeros, so
/// that `session_of` gives the session. No secret has this proof.
SessionProof proof_of_session(std::uint64_t session);

}  // namespace pointreel
