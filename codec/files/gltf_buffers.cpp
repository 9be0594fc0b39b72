#include "codec/files/gltf_buffers.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>

#include "codec/core/json_fields.h"
#include "codec/files/byte_source.h"
#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

int hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The characters that %XX stands for.
std::string decoded(std::string_view uri) {
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? hexadecimal(uri[i + 1]) : -1;
    const int low = high >= 0 ? hexadecimal(uri[i + 2]) : -1;
    path += low >= 0 ? static_cast<char>(16 * high + low) : uri[i];
    if (low >= 0) i += 2;
  }
  return path;
}

/// The file that a relative URI names, if it is in the folder or below.
Result<fs::path> file_of(const std::string& uri, const fs::path& folder) {
  const fs::path path(decoded(uri));
  const auto outside = [&] {
    return fail(concat("uri ", printable(uri), " is not a file in the folder of this one"));
  };
  const bool leaves = std::find(path.begin(), path.end(), "..") != path.end();
  if (path.empty() || path.is_absolute() || leaves ||
      path.string().find('\0') != std::string::npos || uri.find("://") != std::string::npos)
    return outside();
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
  const fs::path file = error ? fs::path() : fs::canonical(root / path, error);
  if (error)
    return fail(ErrorCode::not_found, concat("uri ", printable(uri), ": ", error.message()));
  // Links may lead elsewhere.
  const auto [end, rest] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  if (end != root.end() || !fs::is_regular_file(file, error)) return outside();
  return file;
}

void append_base64(std::string& out, ByteView bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j) bits = bits << 8 | (j < count ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j)
      out += j <= count ? kDigits[bits >> (18 - 6 * j) & 63] : '=';
  }
}

}  // namespace

Result<std::optional<Bytes>> embed_gltf_buffers(ByteView bytes, const fs::path& folder,
                                                std::uint64_t max_bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto root = text.starts_with("glTF") ? fail("is binary") : parse_json(text);
  // What is wrong with it, its reader says.
  if (!root) return std::optional<Bytes>();
  Fields fields(*root);
  if (!fields.has("buffers")) return std::optional<Bytes>();
  std::string out;
  std::size_t done = 0, number = 0;
  std::uint64_t left = max_bytes;
  for (JsonItems item(*fields.value("buffers")); item.next(); ++number) {
    Fields buffer(item.value());
    if (!buffer.has("uri")) continue;
    const std::string uri = buffer.text("uri");
    if (uri.starts_with("data:")) continue;
    const std::string place = concat("buffers/", number);
    const std::uint64_t length = buffer.integer("byteLength", kMaxInteger);
    TRY(at_place(place, buffer.check()));
    const fs::path file = TRY(at_place(place, file_of(uri, folder)));
    const ByteSource source = TRY(at_place(place, ByteSource::open(file)));
    const std::uint64_t size = std::min(length, source.size());
    if (size > left) {
      return fail(ErrorCode::limit, concat(place, ": takes ", size,
                                           " bytes, and with those before more than ", max_bytes));
    }
    left -= size;
    Bytes room;
    const ByteView content =
        TRY(at_place(place, source.view(0, static_cast<std::size_t>(size), room)));
    const std::string_view written = buffer.value("uri")->text();
    const auto begin = static_cast<std::size_t>(written.data() - text.data());
    out += text.substr(done, begin - done);
    out += "\"data:application/octet-stream;base64,";
    append_base64(out, content);
    out += '"';
    done = begin + written.size();
  }
  if (done == 0) return std::optional<Bytes>();
  out += text.substr(done);
  return std::optional<Bytes>(Bytes(out.begin(), out.end()));
}

}  // namespace pointreel
