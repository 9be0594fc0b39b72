#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "server/service/responder.h"

namespace pointreel {

/// Finds the heads of HTTP/1.1 requests in the bytes of a connection. Requests may be pipelined,
/// and may arrive in pieces.
///
/// Trust: the bytes are untrusted. At most kLimit of them are held. A head that is longer, or not
/// HTTP, is refused with a response that says why.
class HeadReader {
 public:
  static constexpr std::size_t kLimit = 8 * 1024;
  enum class State {
    kEmpty,    ///< nothing of a request has arrived
    kPart,     ///< a part of the head has arrived
    kHead,     ///< the head is complete, and `request` returns it
    kRefused,  ///< the head is refused, and `refusal` says why; what follows cannot be understood
  };

  HeadReader();
  ~HeadReader();
  HeadReader(const HeadReader&) = delete;
  HeadReader& operator=(const HeadReader&) = delete;

  /// Where to put the next bytes; never empty while more are needed. `took` says how many were put.
  std::span<char> space();
  void took(std::size_t size);

  /// Examines what has arrived. If the last call returned kHead, continues with the next head.
  State next();

  /// For State::kHead; valid until the next call of `next`.
  const Request& request() const;
  bool keep_alive() const;
  /// The head as it arrived and all bytes after it, to continue in another protocol.
  std::string_view raw() const;
  /// For State::kRefused.
  Response refusal() const;

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace pointreel
