#include "codec/draco/drc_header.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint16_t version(int major, int minor) {
  return static_cast<std::uint16_t>(major * 256 + minor);
}

/// The newest versions that Draco 1.5 writes and reads.
constexpr std::uint16_t kNewestCloud = version(2, 3);
constexpr std::uint16_t kNewestMesh = version(2, 2);
constexpr std::uint16_t kMetadataFlag = 0x8000;
constexpr int kDataTypes = 12;  // 1 to 11 are valid, draco/core/draco_types.h

/// Reads values in Draco's encoding, which has more types than ByteReader.
class DrcReader {
 public:
  explicit DrcReader(ByteView bytes) : bytes_(bytes), reader_(bytes) {}

  template <class T>
  T get() {
    return reader_.get<T>();
  }

  /// LEB128. Draco reads at most five bytes of a 32-bit value and drops excess bits.
  std::uint32_t varint() {
    std::uint32_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const auto byte = reader_.get<std::uint8_t>();
      value |= static_cast<std::uint32_t>(byte & 0x7f) << shift;
      if ((byte & 0x80) == 0) return value;
    }
    bad_ = true;
    return 0;
  }

  /// A count, which takes four bytes in files older than the version that made it a varint.
  std::uint32_t count(std::uint16_t file_version, std::uint16_t varint_since) {
    return file_version < varint_since ? get<std::uint32_t>() : varint();
  }

  void skip(std::size_t n) {
    if (!ok() || reader_.rest().size() < n) {
      bad_ = true;  // kept here, because the new reader does not know that the old one failed
      reader_ = ByteReader({});
      return;
    }
    reader_ = ByteReader(reader_.rest().subspan(n));
  }

  bool ok() const { return !bad_ && reader_.ok(); }
  std::size_t offset() const { return bytes_.size() - reader_.rest().size(); }

 private:
  ByteView bytes_;
  ByteReader reader_;
  bool bad_ = false;
};

/// Steps over a metadata element: its entries, and then the named elements in it. The counts need
/// no bounds, since every entry and element takes at least one byte.
void skip_metadata_element(DrcReader& in) {
  std::vector<std::uint32_t> open = {1};  // numbers of elements left to read, innermost last
  while (!open.empty() && in.ok()) {
    if (open.back() == 0) {
      open.pop_back();
      continue;
    }
    --open.back();
    const bool named = open.size() > 1;
    if (named) in.skip(in.get<std::uint8_t>());
    for (std::uint32_t entries = in.varint(); entries > 0 && in.ok(); --entries) {
      in.skip(in.get<std::uint8_t>());
      in.skip(in.varint());
    }
    open.push_back(in.varint());
  }
}

void skip_metadata(DrcReader& in) {
  for (std::uint32_t left = in.varint(); left > 0 && in.ok(); --left) {
    in.varint();  // the attribute that the element belongs to
    skip_metadata_element(in);
  }
  skip_metadata_element(in);
}

constexpr const char* kTruncated = "the Draco data end within their header: the file is truncated";

Result<DrcHeader> parse_fixed(DrcReader& in, ByteView bytes) {
  if (bytes.size() < 5 || std::memcmp(bytes.data(), "DRACO", 5) != 0) {
    return fail("not Draco data: does not begin with DRACO");
  }
  in.skip(5);
  DrcHeader header;
  const int major = in.get<std::uint8_t>();
  const int minor = in.get<std::uint8_t>();
  header.version = version(major, minor);
  const int geometry = in.get<std::uint8_t>();
  header.method = in.get<std::uint8_t>();
  const auto flags = in.get<std::uint16_t>();
  if (!in.ok()) return fail(kTruncated);
  if (geometry > 1)
    return fail(ErrorCode::unsupported, concat("unknown Draco geometry type ", geometry));
  header.mesh = geometry == 1;
  const std::uint16_t newest = header.mesh ? kNewestMesh : kNewestCloud;
  if (major < 1 || header.version > newest) {
    return fail(ErrorCode::unsupported,
                concat("Draco bitstream version ", major, ".", minor,
                       " is not supported: encode the file again with Draco 1.5 or older"));
  }
  if (header.method > 1) {
    return fail(ErrorCode::unsupported, concat("unknown Draco method ", header.method));
  }
  header.metadata = header.version >= version(1, 3) && (flags & kMetadataFlag) != 0;
  return header;
}

std::uint64_t component_sum(const std::vector<DrcAttribute>& attributes) {
  std::uint64_t sum = 0;
  for (const DrcAttribute& attribute : attributes) sum += attribute.components;
  return sum;
}

/// Reads the number of points and the descriptions of the attributes. For kd-trees, also checks the
/// number of points that is repeated after them.
Result<void> parse_cloud(DrcReader& in, DrcHeader& header) {
  const auto points = in.get<std::uint32_t>();
  header.points = points;
  header.attribute_decoders = in.get<std::uint8_t>();
  if (!in.ok()) return fail(kTruncated);
  for (int decoder = 0; decoder < header.attribute_decoders; ++decoder) {
    const std::uint32_t count = in.count(header.version, version(2, 0));
    if (count == 0) return fail("a Draco attribute decoder has no attributes");
    for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
      DrcAttribute attribute;
      attribute.type = in.get<std::uint8_t>();
      attribute.data_type = in.get<std::uint8_t>();
      attribute.components = in.get<std::uint8_t>();
      attribute.normalized = in.get<std::uint8_t>() != 0;
      if (header.version < version(1, 3)) {
        in.get<std::uint16_t>();
      } else {
        in.varint();
      }
      if (!in.ok()) return fail(kTruncated);
      if (attribute.data_type < 1 || attribute.data_type >= kDataTypes ||
          attribute.components == 0) {
        return fail(concat("Draco attribute ", header.attributes.size(), " has data type ",
                           attribute.data_type, " and ", attribute.components, " components"));
      }
      header.attributes.push_back(attribute);
      if (component_sum(header.attributes) > kMaxComponents) {
        return fail(ErrorCode::limit, concat("the Draco attributes have more than ", kMaxComponents,
                                             " components together"));
      }
    }
    // With sequential coding, one byte for each attribute says how it is coded.
    if (header.method == 0) in.skip(count);
    if (!in.ok()) return fail(kTruncated);
  }
  if (header.method == 1 && header.attribute_decoders > 0) {
    if (header.attribute_decoders > 1)
      return fail("a Draco kd-tree has more than one attribute decoder");
    if (header.version < version(2, 3)) in.get<std::uint8_t>();    // kd-tree of floats or integers
    in.get<std::uint8_t>();                                        // compression level
    if (header.version >= version(2, 3)) in.get<std::uint32_t>();  // bit length
    const auto again = in.get<std::uint32_t>();
    if (!in.ok()) return fail(kTruncated);
    if (again != points) {
      return fail(concat("the Draco header has ", points, " points, but its kd-tree has ", again));
    }
  }
  return {};
}

/// Reads the counts for which Draco allocates memory before it reads a face. The attributes come
/// after the coded connectivity, so their descriptions cannot be read here.
Result<void> parse_mesh(DrcReader& in, DrcHeader& header, std::uint64_t max_points) {
  if (header.method == 0) {
    header.faces = in.count(header.version, version(2, 2));
    header.points = in.count(header.version, version(2, 2));
    return {};
  }
  in.get<std::uint8_t>();  // the coding of the traversal
  std::uint64_t new_vertices = 0;
  if (header.version < version(2, 2)) new_vertices = in.count(header.version, version(2, 0));
  header.points = in.count(header.version, version(2, 0));
  header.faces = in.count(header.version, version(2, 0));
  header.seams = in.get<std::uint8_t>();
  const std::uint64_t symbols = in.count(header.version, version(2, 0));
  const std::uint64_t splits = in.count(header.version, version(2, 0));
  if (in.ok() && (symbols > header.faces || splits > symbols ||
                  header.points + splits > max_points || new_vertices > max_points)) {
    return fail(concat("the Draco mesh has counts that do not fit together (", header.points,
                       " vertices, ", header.faces, " faces, ", symbols, " symbols, ", splits,
                       " splits)"));
  }
  return {};
}

}  // namespace

Result<DrcHeader> parse_drc_header(ByteView bytes, std::uint64_t points_per_byte,
                                   const DecodeLimits& limits) {
  DrcReader in(bytes);
  DrcHeader header = TRY(parse_fixed(in, bytes));
  if (header.metadata) skip_metadata(in);
  if (!in.ok()) return fail(kTruncated);
  header.body = in.offset();

  const std::uint64_t most =
      std::min<std::uint64_t>(limits.max_points, kFreePoints + points_per_byte * bytes.size());
  const Result<void> parsed = header.mesh ? parse_mesh(in, header, most) : parse_cloud(in, header);
  // Checked first, because too large a count also makes the rest of the header fail.
  if (header.points > most || header.faces > kFacesPerPoint * most) {
    const std::string counts = header.mesh
                                   ? concat(header.points, " vertices and ", header.faces, " faces")
                                   : concat(header.points, " points");
    return fail(ErrorCode::limit, concat("the Draco header declares ", counts, " in ", bytes.size(),
                                         " bytes, but at most ", most,
                                         header.mesh ? " vertices" : " points", " are accepted"));
  }
  TRY(parsed);
  if (!in.ok()) return fail(kTruncated);
  return header;
}

}  // namespace pointreel
