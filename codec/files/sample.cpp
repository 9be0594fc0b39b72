#include "codec/files/sample.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "codec/files/attribute_names.h"
#include "codec/files/cloud_file.h"
#include "codec/files/numbers.h"
#include "codec/files/ply_cloud_builder.h"
#include "codec/files/ply_header.h"
#include "codec/files/sweep.h"
#include "codec/files/words.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kPieces = 64, kPieceBytes = std::size_t{16} << 10;
constexpr std::size_t kSampleBytes = kPieces * kPieceBytes;
constexpr std::size_t kMaxPlyHeader = std::size_t{64} << 10;

void append(Bytes& to, ByteView bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }
void append(Bytes& to, std::string_view text) { to.insert(to.end(), text.begin(), text.end()); }

/// Where the pieces of a part of a file begin, evenly spread from its first to its last byte, each
/// a multiple of `unit` from `begin`.
std::uint64_t piece_offset(std::size_t piece, std::uint64_t begin, std::uint64_t end,
                           std::size_t unit, std::size_t bytes) {
  const std::uint64_t last = (end - begin - std::min<std::uint64_t>(end - begin, bytes)) / unit;
  return begin + last * piece / (kPieces - 1) * unit;
}

/// Whole records of `unit` bytes from byte `begin` on.
Result<void> add_records(const ByteSource& source, std::uint64_t begin, std::uint64_t end,
                         std::size_t unit, Bytes& sample) {
  const std::size_t bytes = std::max<std::size_t>(1, kPieceBytes / unit) * unit;
  Bytes room;
  for (std::size_t piece = 0; piece < kPieces; ++piece) {
    const std::uint64_t at = piece_offset(piece, begin, end, unit, bytes);
    const ByteView view = TRY(
        source.view(at, static_cast<std::size_t>(std::min<std::uint64_t>(bytes, end - at)), room));
    append(sample, view.first(view.size() / unit * unit));
  }
  return {};
}

Result<std::optional<Bytes>> whole(const ByteSource& source) {
  Bytes room;
  const ByteView bytes = TRY(source.all(room));
  return std::optional<Bytes>(Bytes(bytes.begin(), bytes.end()));
}

bool ends_line(std::uint8_t byte) { return byte == '\n' || byte == '\r'; }

/// Whole lines from byte `begin` on, where one begins. `pieces`: kPieces, or 1 for the first alone.
Result<std::size_t> add_lines(const ByteSource& source, std::uint64_t begin, std::size_t pieces,
                              std::size_t bytes, Bytes& sample) {
  Bytes room;
  const std::size_t before = sample.size();
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const std::uint64_t at = piece_offset(piece, begin, source.size(), 1, bytes);
    ByteView view = TRY(source.view(at, bytes, room));
    if (piece > 0) {
      const auto first = std::find_if(view.begin(), view.end(), ends_line);
      if (first == view.end()) continue;
      view = view.subspan(static_cast<std::size_t>(first - view.begin()) + 1);
    }
    if (at + view.size() < source.size() || piece > 0) {
      std::size_t end = view.size();
      while (end > 0 && !ends_line(view[end - 1])) --end;
      view = view.first(end);
    }
    append(sample, view);
  }
  return static_cast<std::size_t>(
      std::count_if(sample.begin() + static_cast<std::ptrdiff_t>(before), sample.end(), ends_line));
}

const char* name_of(PlyType type) {
  constexpr std::array<const char*, 8> kNames{"char", "uchar", "short", "ushort",
                                              "int",  "uint",  "float", "double"};
  return kNames[static_cast<std::size_t>(type)];
}

/// Whether the types of colours do not tell what stands for full brightness.
bool has_loose_colors(const PlyElement& vertex, const PlyRoles& roles) {
  if (roles[kColor] < 0 || roles[kColor + 1] < 0 || is_splat(vertex)) return false;
  return size_of(vertex.properties[static_cast<std::size_t>(roles[kColor])].type) > 1;
}

bool has_fields_that_may_say_nothing(const PlyElement& vertex) {
  return std::ranges::any_of(vertex.properties, [](const PlyProperty& property) {
    return may_say_nothing(property.name);
  });
}

Result<std::optional<Bytes>> ply_sample(const ByteSource& source) {
  Bytes room;
  const auto header = parse_ply_header(TRY(source.view(0, kMaxPlyHeader, room)));
  // Reading the file says what is wrong.
  if (!header) return std::optional<Bytes>();
  const auto vertex_at = std::find_if(header->elements.begin(), header->elements.end(),
                                      [](const PlyElement& e) { return e.name == "vertex"; });
  if (vertex_at == header->elements.end()) return std::optional<Bytes>();
  const PlyElement& vertex = *vertex_at;
  const auto roles = assign_roles(vertex);
  if (!roles || (!has_loose_colors(vertex, *roles) && !has_fields_that_may_say_nothing(vertex)))
    return std::optional<Bytes>();
  std::size_t row = 0;
  bool fixed = vertex_at == header->elements.begin();
  for (const PlyProperty& property : vertex.properties) {
    row += size_of(property.type);
    fixed &= !property.is_list;
  }
  if (source.size() <= kSampleBytes || !fixed || row > kPieceBytes) return whole(source);
  Bytes rows;
  std::uint64_t count = 0;
  if (header->format == PlyFormat::ascii) {
    // Lines of other elements must not be taken for vertices.
    const bool alone = header->elements.size() == 1;
    const std::size_t lines = TRY(add_lines(source, header->size, alone ? kPieces : 1,
                                            alone ? kPieceBytes : kSampleBytes, rows));
    count = std::min<std::uint64_t>(vertex.count, lines);
  } else {
    const std::uint64_t there = (source.size() - header->size) / row;
    const std::uint64_t end = header->size + std::min(there, vertex.count) * row;
    TRY(add_records(source, header->size, end, row, rows));
    count = rows.size() / row;
  }
  const char* format = header->format == PlyFormat::ascii           ? "ascii"
                       : header->format == PlyFormat::little_endian ? "binary_little_endian"
                                                                    : "binary_big_endian";
  std::string text = concat("ply\nformat ", format, " 1.0\nelement vertex ", count, "\n");
  for (const PlyProperty& property : vertex.properties)
    text += concat("property ", name_of(property.type), " ", property.name, "\n");
  Bytes sample;
  append(sample, text + "end_header\n");
  append(sample, rows);
  return std::optional<Bytes>(std::move(sample));
}

/// As an older version of LAS, whose header is short.
Result<std::optional<Bytes>> las_sample(const ByteSource& source) {
  constexpr std::size_t kMinor = 25, kHeaderSize = 94, kPoints = 96, kRecordSize = 105,
                        kCount = 107, kOldHeader = 227, kLongCount = 247, kNewHeader = 375;
  Bytes room;
  const ByteView header = TRY(source.view(0, kNewHeader, room));
  if (header.size() < kNewHeader) return std::optional<Bytes>();
  const std::uint64_t begin = load_number<std::uint32_t>(&header[kPoints]);
  const std::size_t size = load_number<std::uint16_t>(&header[kRecordSize]);
  if (begin < kOldHeader || begin >= source.size() || size == 0) return std::optional<Bytes>();
  std::uint64_t count = load_number<std::uint32_t>(&header[kCount]);
  if (count == 0 && header[kMinor] == 4) count = load_number<std::uint64_t>(&header[kLongCount]);
  const std::uint64_t there = (source.size() - begin) / size;
  if (count == 0 || count > there) count = there;
  Bytes sample(header.begin(), header.begin() + kOldHeader);
  TRY(add_records(source, begin, begin + count * size, size, sample));
  sample[kMinor] = std::min<std::uint8_t>(sample[kMinor], 2);
  store_number(NumberType::uint16, kOldHeader, &sample[kHeaderSize]);
  store_number(NumberType::uint32, kOldHeader, &sample[kPoints]);
  store_number(NumberType::uint32, static_cast<double>((sample.size() - kOldHeader) / size),
               &sample[kCount]);
  return std::optional<Bytes>(std::move(sample));
}

/// Whether the header has fields that may be colours in numbers of their own, or say nothing.
Result<bool> has_unclear_pcd_fields(const ByteSource& source) {
  constexpr std::size_t kHeader = 4096;
  Bytes room;
  const ByteView begin = TRY(source.view(0, kHeader, room));
  Lines lines(text_of(begin));
  for (std::string_view line; lines.next(line);) {
    if (in_capitals(take_word(line)) != "FIELDS") continue;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      for (const VectorNames& names : kColorNames)
        if (equal_in_any_case(word, names[0]) || may_say_nothing(word)) return true;
    }
    return false;
  }
  return true;
}

}  // namespace

Result<std::optional<Bytes>> sample_of(const ByteSource& source, CloudFormat format) {
  const bool small = source.size() <= kSampleBytes;
  Bytes sample;
  switch (format) {
    case CloudFormat::text:
    case CloudFormat::obj:
      if (small) return whole(source);
      TRY(add_lines(source, 0, kPieces, kPieceBytes, sample));
      return std::optional<Bytes>(std::move(sample));
    case CloudFormat::sweep:
      if (small) return whole(source);
      TRY(add_records(source, 0, source.size(), kSweepUnit, sample));
      return std::optional<Bytes>(std::move(sample));
    case CloudFormat::las:
      return small ? whole(source) : las_sample(source);
    case CloudFormat::pcd:
      if (!TRY(has_unclear_pcd_fields(source))) return std::optional<Bytes>();
      return whole(source);
    case CloudFormat::ply:
      return ply_sample(source);
    case CloudFormat::numpy:
      return whole(source);
    default:
      return std::optional<Bytes>();
  }
}

}  // namespace pointreel
