// Servers may compress manifests, and hostile ones may send bombs.

#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/scripted_http_server.h"
#include "tests/small_package.h"

namespace pointreel::http_compression_test {
namespace {

using testing::HasSubstr;

constexpr std::string_view kGzipHead("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);

std::string little_endian(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
  return bytes;
}

std::uint32_t crc32(std::string_view text) {
  std::uint32_t crc = ~0u;
  for (const char c : text) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

/// The text as gzip (RFC 1952) in one block that is not compressed (RFC 1951).
std::string gzip(std::string_view text) {
  const auto size = static_cast<std::uint32_t>(text.size());
  return std::string(kGzipHead) + "\x01" + little_endian(size | (~size << 16)) + std::string(text) +
         little_endian(crc32(text)) + little_endian(size);
}

/// Gzip of `runs` times 258 spaces, 13 bits for each: a literal, then repetitions of it.
std::string gzip_of_spaces(int runs) {
  std::string bytes(kGzipHead);
  unsigned bits = 0;
  int count = 0;
  const auto put = [&](unsigned code, int length) {  // from the highest bit of the code on
    for (int i = length - 1; i >= 0; --i) {
      bits |= (code >> i & 1u) << count;
      if (++count < 8) continue;
      bytes += static_cast<char>(bits);
      bits = 0;
      count = 0;
    }
  };
  put(0b110, 3);  // the last block, with fixed codes
  put(0x30 + ' ', 8);
  for (int i = 0; i < runs; ++i) put(0b11000101 << 5, 13);  // 258 bytes from one byte back
  return bytes + std::string(16, '\0');
}

/// The error of opening a package whose manifest is answered so, or "opened".
std::string opened(const std::string& headers, const std::string& body) {
  ScriptedHttpServer server([&](int socket, const std::string&) {
    answer(socket, "200 OK", headers, body);
    return true;
  });
  const auto source = open_source(server.url() + "/reel", patient());
  return source ? "opened" : source.error().message;
}

TEST(HttpCompression, of_a_manifest_is_undone) {
  const std::string text = write_manifest(small_manifest());
  EXPECT_EQ(opened("Content-Encoding: gzip\r\n", gzip(text)), "opened");
  EXPECT_EQ(opened("Content-Encoding: identity\r\n", text), "opened");
}

TEST(HttpCompression, is_refused_where_it_is_applied_twice) {
  const std::string twice = gzip(gzip(write_manifest(small_manifest())));
  for (const char* headers : {"Content-Encoding: gzip, gzip\r\n", "content-encoding:gzip,gzip\r\n",
                              "Content-Encoding: gzip\r\nContent-Encoding: gzip\r\n",
                              "Transfer-Encoding: gzip\r\nContent-Encoding: gzip\r\n"}) {
    EXPECT_THAT(opened(headers, twice), HasSubstr("compresses the answer more than once"))
        << headers;
  }
}

TEST(HttpCompression, of_more_than_a_manifest_may_have_is_noticed_while_it_is_undone) {
  const std::string bomb = gzip_of_spaces(static_cast<int>(kMaxManifestBytes / 258 + 1));
  EXPECT_LT(bomb.size(), std::size_t{256} << 10);
  EXPECT_THAT(opened("Content-Encoding: gzip\r\n", bomb),
              HasSubstr(fmt::format("more than the {} bytes expected", kMaxManifestBytes)));
}

}  // namespace
}  // namespace pointreel::http_compression_test
