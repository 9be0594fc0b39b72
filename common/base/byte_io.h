#pragma once

#include <cstring>
#include <type_traits>

#include "pointreel/bytes.h"

namespace pointreel {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "Pointreel's formats are little endian, and so must be the machine");

/// Appends little-endian values to a byte string.
class ByteWriter {
 public:
  explicit ByteWriter(Bytes& out) : out_(out) {}

  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }

 private:
  Bytes& out_;
};

/// Reads little-endian values from untrusted bytes. Past the end, every value is zero and `ok()`
/// stays false, so that a parser needs to check only once, after its last field.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    if (rest_.size() < sizeof(T)) {
      ok_ = false;
      rest_ = {};
      return value;
    }
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_ = rest_.subspan(sizeof(T));
    return value;
  }

  bool ok() const { return ok_; }
  ByteView rest() const { return rest_; }

 private:
  ByteView rest_;
  bool ok_ = true;
};

}  // namespace pointreel
