#include "codec/files/las.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "codec/files/records.h"
#include "common/base/concat.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// What the formats of points have. Those from 6 on are of LAS 1.4.
struct PointFormat {
  std::uint16_t size = 0;   ///< in bytes, without extra bytes
  std::uint16_t color = 0;  ///< where red is; 0: there is no colour
  bool time = false, infrared = false, waveform = false;
};
constexpr std::array<PointFormat, 11> kPointFormats{{{20},
                                                     {28, 0, true},
                                                     {26, 20},
                                                     {34, 28, true},
                                                     {57, 0, true, false, true},
                                                     {63, 28, true, false, true},
                                                     {30, 0, true},
                                                     {36, 30, true},
                                                     {38, 30, true, true},
                                                     {59, 0, true, false, true},
                                                     {67, 30, true, true, true}}};

/// Bytes of headers, from the begin of the file.
constexpr std::size_t kVersion = 24, kHeaderSize = 94, kPoints = 96, kFormat = 104,
                      kRecordSize = 105, kCount = 107, kScale = 131, kOffset = 155,
                      kOldHeader = 227, kWaveforms = 227, kExtendedRecords = 235,
                      kExtendedCount = 243, kLongCount = 247, kNewHeader = 375;
/// Set in the format's number by programs that write LAZ.
constexpr std::uint8_t kCompressed = 0xc0;

template <class T>
T at(ByteView bytes, std::size_t offset) {
  return load_number<T>(bytes.data() + offset);
}

glm::dvec3 vector_at(ByteView bytes, std::size_t offset) {
  return {at<double>(bytes, offset), at<double>(bytes, offset + 8), at<double>(bytes, offset + 16)};
}

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

struct LasHeader {
  RecordTable table;
  std::uint64_t points_end = ~std::uint64_t{0};  ///< where something else begins
  std::uint8_t format = 0;
  glm::dvec3 scale{1.0}, offset{0.0};
};

void end_points_at(std::uint64_t offset, LasHeader& header) {
  if (offset > header.table.begin) header.points_end = std::min(header.points_end, offset);
}

Result<LasHeader> parse_header(ByteView bytes) {
  if (bytes.size() < kOldHeader) {
    return fail(
        concat("byte ", bytes.size(), ": the header ends before its ", kOldHeader, " bytes"));
  }
  const int major = bytes[kVersion], minor = bytes[kVersion + 1];
  if (major != 1 || minor > 4) {
    return fail(ErrorCode::unsupported,
                concat("is of LAS version ", major, ".", minor, "; 1.0 to 1.4 can be read"));
  }
  LasHeader header;
  const std::uint8_t format = bytes[kFormat];
  if ((format & kCompressed) != 0) {
    return fail(ErrorCode::unsupported,
                "is compressed (LAZ), which is not read: convert it with \"pdal translate IN.laz "
                "OUT.las\" or \"las2las -i IN.laz -o OUT.las\"");
  }
  if (format >= kPointFormats.size()) {
    return fail(ErrorCode::unsupported, concat("byte ", kFormat, ": has the point format ",
                                               static_cast<int>(format), "; 0 to 10 can be read"));
  }
  header.format = format;
  header.table.size = at<std::uint16_t>(bytes, kRecordSize);
  if (header.table.size < kPointFormats[format].size) {
    return fail(concat("byte ", kRecordSize, ": points of ", header.table.size,
                       " bytes are too short for the point format ", static_cast<int>(format),
                       ", which needs ", kPointFormats[format].size));
  }
  header.table.begin = at<std::uint32_t>(bytes, kPoints);
  if (header.table.begin <
      std::max<std::size_t>(at<std::uint16_t>(bytes, kHeaderSize), kOldHeader)) {
    return fail(concat("byte ", kPoints, ": the points begin at byte ", header.table.begin,
                       ", within the header"));
  }
  header.table.count = at<std::uint32_t>(bytes, kCount);
  if (minor == 4 && at<std::uint16_t>(bytes, kHeaderSize) >= kNewHeader) {
    if (bytes.size() < kNewHeader) {
      return fail(
          concat("byte ", bytes.size(), ": the header ends before its ", kNewHeader, " bytes"));
    }
    const auto count = at<std::uint64_t>(bytes, kLongCount);
    if (count > 0) header.table.count = count;
    if (at<std::uint32_t>(bytes, kExtendedCount) > 0)
      end_points_at(at<std::uint64_t>(bytes, kExtendedRecords), header);
  }
  if (minor >= 3 && bytes.size() >= kWaveforms + 8 &&
      at<std::uint16_t>(bytes, kHeaderSize) >= kWaveforms + 8)
    end_points_at(at<std::uint64_t>(bytes, kWaveforms), header);
  header.scale = vector_at(bytes, kScale);
  header.offset = vector_at(bytes, kOffset);
  if (!finite(header.scale) || header.scale.x == 0.0 || header.scale.y == 0.0 ||
      header.scale.z == 0.0) {
    return fail(concat("byte ", kScale, ": the scale of coordinates is ", header.scale.x, ", ",
                       header.scale.y, ", ", header.scale.z, ", which places no points"));
  }
  if (!finite(header.offset))
    return fail(concat("byte ", kOffset, ": the offset of coordinates is not finite"));
  return header;
}

/// Programs that end early leave the count of points at 0, or too low.
void correct_count(LasHeader& header, std::uint64_t file_size, ReadNotes& notes) {
  RecordTable& table = header.table;
  const std::uint64_t end = std::min(header.points_end, file_size);
  const std::uint64_t bytes = end - std::min(end, table.begin), room = bytes / table.size;
  if (room <= table.count) return;
  // Something else may follow, unless there is nothing but points.
  const bool are_points = table.count == 0 || bytes % table.size == 0;
  notes.warnings.push_back(concat("the header says ", table.count, " points, but there are ",
                                  are_points ? concat(room, ": all are read")
                                             : concat(bytes - table.count * table.size,
                                                      " bytes behind them that are not read")));
  if (are_points) table.count = room;
}

}  // namespace

Result<PointCloud> read_las(const ByteSource& source, ReadNotes& notes) {
  Bytes room;
  LasHeader header = TRY(parse_header(TRY(source.view(0, kNewHeader, room))));
  correct_count(header, source.size(), notes);
  const PointFormat& format = kPointFormats[header.format];
  const auto vector = [&](std::size_t offset, NumberType type) {
    RecordVector fields;
    for (std::size_t i = 0; i < 3; ++i)
      fields[i] = {offset + i * size_of(type), header.table.size, type};
    return fields;
  };
  RecordLayout layout;
  layout.position = vector(0, NumberType::int32);
  layout.scale = header.scale;
  layout.offset = header.offset;
  if (format.color > 0) layout.color = vector(format.color, NumberType::uint16);
  const auto scalar = [&](const char* name, std::size_t offset, NumberType type,
                          std::uint8_t mask = 255) {
    layout.scalars.push_back({name, {offset, header.table.size, type}, mask});
  };
  const bool old = header.format < 6;  // with fewer classes and returns
  scalar("intensity", 12, NumberType::uint16);
  scalar("return number", 14, NumberType::uint8, old ? 0x07 : 0x0f);
  scalar("classification", old ? 15 : 16, NumberType::uint8, old ? 0x1f : 0xff);
  if (format.infrared) scalar("infrared", 36, NumberType::uint16);
  notes.unread.insert(notes.unread.end(), {"flags", "scan angle", "user data", "point source"});
  if (format.time) notes.unread.push_back("GPS time");
  if (format.waveform) notes.unread.push_back("waveform");
  if (header.table.size > format.size) notes.unread.push_back("extra bytes");
  PointCloud cloud = TRY(read_records(source, header.table, layout, notes));
  // Some point formats have room for colours, whether any were measured or not.
  const auto is_black = [](const glm::u16vec3& color) { return color == glm::u16vec3(0); };
  if (std::ranges::all_of(cloud.colors, is_black)) {
    if (!cloud.colors.empty()) notes.unread.push_back("colours (0 at all points)");
    cloud.colors.clear();
  }
  return cloud;
}

}  // namespace pointreel
