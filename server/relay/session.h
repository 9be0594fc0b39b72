#pragma once

#include <array>
#include <cstdint>

#include "common/stream/live.h"

namespace pointreel {

/// What the server keeps of a publisher's secret: its SHA-256. It recognises the publisher, but
/// nobody can find the secret from it.
using SessionProof = std::array<std::uint8_t, 32>;
SessionProof proof_of(const LiveSecret& secret);

/// The session as viewers see it: the first 64 bits of the proof. It is the same after the server
/// was started again.
std::uint64_t session_of(const SessionProof& proof);

}  // namespace pointreel
