#include <cstring>
#include <string_view>
#include <utility>

#include "codec/draco/drc_reader.h"
#include "codec/files/cloud_file.h"
#include "codec/files/ply.h"
#include "common/base/try.h"

// In place of codec/files: pages are not given any other files.

namespace pointreel {

CloudFormat format_of(ByteView begin, std::string_view) {
  const auto begins_with = [&](std::string_view text) {
    return begin.size() >= text.size() && std::memcmp(begin.data(), text.data(), text.size()) == 0;
  };
  if (begins_with("ply") || begins_with("PLY")) return CloudFormat::ply;
  return begins_with("DRACO") ? CloudFormat::drc : CloudFormat::unknown;
}

bool has_empty_points(CloudFormat) { return false; }

Result<LoadedCloud> read_cloud(ByteView bytes, CloudFormat format, const DecodeLimits& limits,
                               const Reading&) {
  switch (format) {
    case CloudFormat::ply:
      return usable_cloud(TRY(read_ply(bytes)), format);
    case CloudFormat::drc:
      return usable_cloud(TRY(read_drc(bytes, limits)), format);
    default:
      return fail(bytes.empty() ? "the file is empty" : "is neither a PLY nor a Draco file");
  }
}

}  // namespace pointreel
