#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The bytes of a file: in memory, or on disk. Those on disk are read when they are asked for, so
/// that a reader of records needs no memory for the file. May be used by several threads at once.
class ByteSource {
 public:
  /// Bytes that outlive this object.
  explicit ByteSource(ByteView memory) : memory_(memory), size_(memory.size()) {}
  /// A regular file. Errors do not contain the path: as OpenFile::open, and `limit` if what has to
  /// be in memory does not fit.
  static Result<ByteSource> open(const std::filesystem::path& path);
  /// The same, but also a pipe, which is read to its end. Only for paths that the user named. If
  /// `stopped` says so while nothing comes: the error `cancelled`.
  static Result<ByteSource> open_named(const std::filesystem::path& path,
                                       const std::function<bool()>& stopped = {});
  ByteSource(ByteSource&& other) noexcept;
  ByteSource& operator=(ByteSource&&) = delete;
  ~ByteSource();

  /// When the file was opened. It may be shorter by now.
  std::uint64_t size() const { return size_; }

  /// The `count` bytes from `offset` on; fewer where the file ends before. `room` holds them if
  /// they come from a disk, and must outlive them. Errors: `io`, `limit`.
  Result<ByteView> view(std::uint64_t offset, std::size_t count, Bytes& room) const;
  /// All bytes.
  Result<ByteView> all(Bytes& room) const;

 private:
  ByteSource() = default;
  Result<void> read_all(const std::function<bool()>& stopped = {});

  int descriptor_ = -1;  ///< of a file on disk
  Bytes own_;            ///< of a file that was read to its end
  ByteView memory_;      ///< used if there is no descriptor
  std::uint64_t size_ = 0;
};

}  // namespace pointreel
