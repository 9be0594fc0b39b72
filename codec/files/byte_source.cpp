#include "codec/files/byte_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "common/base/try.h"
#include "common/file_system/descriptor.h"
#include "common/file_system/open_file.h"

namespace pointreel {
namespace {

constexpr const char* kNoMemory = "is too large for the memory";

tl::unexpected<Error> failed(const char* what) {
  return fail(ErrorCode::io, fmt::format("{}: {}", what, std::strerror(errno)));
}

/// Reads what has no size that could be relied on: pipes, and files of /proc.
Result<Bytes> read_to_end(int descriptor, const std::function<bool()>& stopped) {
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  try {
    Bytes bytes;
    const auto ended = [&] { return stopped && stopped(); };
    while (wait_readable(descriptor, ended)) {
      const std::size_t at = bytes.size();
      bytes.resize(at + kBlock);
      const ssize_t got = ::read(descriptor, bytes.data() + at, kBlock);
      bytes.resize(at + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (got < 0) return failed("cannot be read to its end");
      if (got == 0) return bytes;
    }
    if (!ended()) return failed("cannot be read to its end");
    return fail(ErrorCode::cancelled, "interrupted before all of it came");
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, kNoMemory);
  }
}

}  // namespace

ByteSource::ByteSource(ByteSource&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      own_(std::move(other.own_)),
      memory_(other.memory_),
      size_(other.size_) {}

ByteSource::~ByteSource() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<ByteSource> ByteSource::open(const std::filesystem::path& path) {
  OpenFile file = TRY(OpenFile::open(path));
  ByteSource source;
  source.size_ = file.size();
  source.descriptor_ = file.release();
  // Files of /proc have no size.
  if (source.size_ == 0) TRY(source.read_all());
  return source;
}

Result<ByteSource> ByteSource::open_named(const std::filesystem::path& path,
                                          const std::function<bool()>& stopped) {
  std::error_code ignored;
  const std::filesystem::file_status kind = std::filesystem::status(path, ignored);
  if (!is_fifo(kind) && !is_socket(kind)) return open(path);
  ByteSource source;
  // Opening it any other way waits for whoever writes.
  source.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (source.descriptor_ < 0) return failed("cannot be opened");
  TRY(source.read_all(stopped));
  return source;
}

Result<void> ByteSource::read_all(const std::function<bool()>& stopped) {
  own_ = TRY(read_to_end(descriptor_, stopped));
  ::close(std::exchange(descriptor_, -1));
  memory_ = own_;
  size_ = own_.size();
  return {};
}

Result<ByteView> ByteSource::view(std::uint64_t offset, std::size_t count, Bytes& room) const {
  if (offset >= size_) return ByteView();
  count = static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - offset));
  if (descriptor_ < 0) return memory_.subspan(static_cast<std::size_t>(offset), count);
  try {
    if (room.size() < count) room.resize(count);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit, kNoMemory);
  }
  std::size_t got = 0;
  while (got < count) {
    const ssize_t n =
        ::pread(descriptor_, room.data() + got, count - got, static_cast<off_t>(offset + got));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed("cannot be read to its end");
    if (n == 0) break;  // it has become shorter
    got += static_cast<std::size_t>(n);
  }
  return ByteView(room.data(), got);
}

Result<ByteView> ByteSource::all(Bytes& room) const {
  return view(0, static_cast<std::size_t>(size_), room);
}

}  // namespace pointreel
