#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <vector>

#include <fmt/format.h>

#include "client/scene/radiance_picture.h"

// Apart from the parser, which a browser's player has, too, without files.

namespace pointreel {
namespace {

constexpr std::size_t kMostBytes = std::size_t{256} << 20;

}  // namespace

Result<EnvironmentMap> load_environment(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    return fail(errno == ENOENT ? ErrorCode::not_found : ErrorCode::io,
                fmt::format("{}: cannot be opened: {}", file, std::strerror(errno)));
  std::vector<std::uint8_t> bytes;
  std::vector<char> part(std::size_t{1} << 20);
  while (in.read(part.data(), static_cast<std::streamsize>(part.size())), in.gcount() > 0) {
    bytes.insert(bytes.end(), part.begin(), part.begin() + in.gcount());
    if (bytes.size() > kMostBytes)
      return fail(ErrorCode::limit,
                  file + ": is larger than 256 MiB; make it smaller: light needs few pixels");
  }
  if (in.bad()) return fail(ErrorCode::io, file + ": cannot be read");
  auto map = parse_radiance(bytes);
  if (!map) return fail_at(file, map.error());
  return map;
}

}  // namespace pointreel
