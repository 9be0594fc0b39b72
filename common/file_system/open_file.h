#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "pointreel/error.h"

/// Files that others made: those inside of packages and captures.
namespace pointreel {

/// An open file, closed with its owner.
class OpenFile {
 public:
  /// Opens a regular file for reading, and nothing else: opening a pipe would wait for somebody who
  /// writes, and opening a device may have effects. Errors do not contain the path: `not_found`,
  /// `io`, `invalid`.
  static Result<OpenFile> open(const std::filesystem::path& path);
  OpenFile(OpenFile&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}
  OpenFile& operator=(OpenFile&&) = delete;
  ~OpenFile();

  int descriptor() const { return descriptor_; }
  /// When it was opened. It may be shorter by now.
  std::uint64_t size() const { return size_; }
  /// Hands the descriptor over.
  int release() { return std::exchange(descriptor_, -1); }

 private:
  OpenFile(int descriptor, std::uint64_t size) : descriptor_(descriptor), size_(size) {}

  int descriptor_;
  std::uint64_t size_;
};

/// The text of such a file, of at most `most` bytes. If it is replaced meanwhile, that of one of
/// both. Errors do not contain the path: as OpenFile::open, and `limit`.
Result<std::string> read_text(const std::filesystem::path& path, std::uint64_t most);

/// Such a file as a stream.
Result<std::ifstream> open_stream(const std::filesystem::path& path);

}  // namespace pointreel
