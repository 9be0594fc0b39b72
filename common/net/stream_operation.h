#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

#include <boost/asio/buffer.hpp>

/// What a stream that Beast reads and writes takes for an operation, in types that do not depend on
/// the caller. The stream's own operations are then no templates: Asio's take long to compile for
/// each of Beast's handlers and sequences of buffers.
namespace pointreel {

/// What an operation calls at its end, once.
class Completion {
 public:
  template <class Handler>
    requires(!std::same_as<std::decay_t<Handler>, Completion>)
  explicit Completion(Handler&& handler)
      : call_(std::make_unique<Of<std::decay_t<Handler>>>(std::forward<Handler>(handler))) {}

  void operator()(boost::system::error_code error, std::size_t size = 0) {
    const auto call = std::move(call_);
    (*call)(error, size);
  }

 private:
  struct Call {
    virtual ~Call() = default;
    virtual void operator()(boost::system::error_code error, std::size_t size) = 0;
  };
  template <class Handler>
  struct Of : Call {
    template <class From>
    explicit Of(From&& from) : handler(std::forward<From>(from)) {}
    void operator()(boost::system::error_code error, std::size_t size) override {
      if constexpr (std::invocable<Handler&, boost::system::error_code, std::size_t>) {
        handler(error, size);
      } else {
        handler(error);
      }
    }
    Handler handler;
  };

  std::unique_ptr<Call> call_;
};

/// The first buffers of a sequence that are not empty; behind them, empty ones.
template <class Buffer>
using Pieces = std::array<Buffer, 4>;

template <class Buffer, class Buffers>
Pieces<Buffer> first_pieces(const Buffers& buffers) {
  Pieces<Buffer> first;
  std::size_t count = 0;
  const auto end = boost::asio::buffer_sequence_end(buffers);
  for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end; ++at) {
    const Buffer buffer(*at);
    if (buffer.size() == 0) continue;
    if (count == first.size()) break;
    first[count++] = buffer;
  }
  return first;
}

}  // namespace pointreel
