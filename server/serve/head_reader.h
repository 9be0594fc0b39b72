#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "server/serve/responder.h"

namespace pointreel {

/// The heads of HTTP/1.1 requests out of the bytes of a connection, pipelined or in pieces.
///
/// Trust: the bytes are untrusted. No more than kLimit of them are held, and a head that is longer,
/// or no HTTP, is refused with the response that says why.
class HeadReader {
 public:
  static constexpr std::size_t kLimit = 8 * 1024;
  enum class State {
    kEmpty,    ///< nothing of a request has come
    kPart,     ///< the head goes on
    kHead,     ///< `request` tells it
    kRefused,  ///< `refusal` tells why; what follows cannot be understood
  };

  HeadReader();
  ~HeadReader();
  HeadReader(const HeadReader&) = delete;
  HeadReader& operator=(const HeadReader&) = delete;

  /// Where the next bytes may be put, never empty while more are wanted; `took` says how many were.
  std::span<char> space();
  void took(std::size_t size);

  /// Looks at what has come. A head that was told before is forgotten, and the next one begins.
  State next();

  /// Of State::kHead, until the next call of `next`.
  const Request& request() const;
  bool keep_alive() const;
  /// The head as it came, and all bytes behind it: for who goes on in another protocol.
  std::string_view raw() const;
  /// Of State::kRefused.
  Response refusal() const;

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace pointreel
