// The header of every decoder must say how it treats hostile bytes.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pointreel/chunks.h"
#include "tests/paths.h"

namespace pointreel::trust_test {
namespace {

namespace fs = std::filesystem;

bool reads_bytes(const std::string& header) {
  static const std::regex reader(
      R"re(\b(decode|parse|read|unpack)\w*\([^;{)]*\b(ByteView|Chunks<ByteView>|ParsedChunk)\b)re");
  return std::regex_search(header, reader);
}

bool tells_its_trust(const std::string& header) {
  return header.find("Trust: ") != std::string::npos ||
         header.find("Trusts nothing: ") != std::string::npos;
}

TEST(Trust, every_header_that_reads_bytes_documents_hostile_input) {
  std::vector<std::string> readers, silent;
  for (const char* part : {"common", "codec", "client", "server"}) {
    const fs::path folder = source_folder() / part;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".h") continue;
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string header(std::istreambuf_iterator<char>(in), {});
      if (!reads_bytes(header)) continue;
      readers.push_back(entry.path());
      if (!tells_its_trust(header)) silent.push_back(entry.path());
    }
  }
  EXPECT_GT(readers.size(), 10u);
  EXPECT_THAT(silent, testing::IsEmpty());
}

TEST(Trust, a_reader_without_such_documentation_is_noticed) {
  EXPECT_TRUE(reads_bytes("Result<Cloud> read_cloud(\n    ByteView bytes, int limit);"));
  EXPECT_TRUE(reads_bytes("Result<void> decode_layer(const ParsedChunk& chunk);"));
  EXPECT_FALSE(reads_bytes("Bytes encode(ByteView raw); int read_count();"));
  EXPECT_FALSE(tells_its_trust("/// Reads a cloud."));
}

}  // namespace
}  // namespace pointreel::trust_test
