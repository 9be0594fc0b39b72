#include "codec/files/recording_writer.h"

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include "codec/files/mcap_records.h"
#include "codec/files/point_records.h"
#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "pointreel/version.h"

namespace pointreel {
namespace {

using namespace mcap;

constexpr std::uint16_t kId = 1;  ///< of the only schema and the only channel
constexpr std::string_view kZstd = "zstd";
/// As fast as disks are. More effort gains little on floats.
constexpr int kZstdLevel = 1;
constexpr std::uint64_t kMostMessageBytes = std::uint64_t{1} << 30;

/// The members of a PointCloud2, as readers need them to decode it.
constexpr std::string_view kDefinition = R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)";
constexpr std::uint8_t kFloat32 = 7, kFloat64 = 8;

/// Inlined, g++ 12 warns that it writes behind the end.
[[gnu::noinline]] void put_bytes(Bytes& out, const void* bytes, std::size_t size) {
  const std::size_t at = out.size();
  out.resize(at + size);
  std::memcpy(out.data() + at, bytes, size);
}

void put_string(Bytes& out, std::string_view text) {
  ByteWriter(out).put(static_cast<std::uint32_t>(text.size()));
  put_bytes(out, text.data(), text.size());
}

/// Appends a record, whose content `write` appends.
template <class Write>
void put_record(Bytes& out, Opcode opcode, const Write& write) {
  out.push_back(opcode);
  const std::size_t at = out.size();
  out.resize(at + sizeof(std::uint64_t));
  write(out);
  const std::uint64_t size = out.size() - at - sizeof(std::uint64_t);
  std::memcpy(out.data() + at, &size, sizeof(size));
}

/// Appends numbers aligned to their size, counted from `begin`.
class CdrWriter {
 public:
  explicit CdrWriter(Bytes& out) : out_(out), begin_(out.size()) {}
  template <class T>
  void put(T value) {
    while ((out_.size() - begin_) % sizeof(T) != 0) out_.push_back(0);
    ByteWriter(out_).put(value);
  }
  void put_string(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    put_bytes(out_, text.data(), text.size());
    out_.push_back(0);
  }

 private:
  Bytes& out_;
  std::size_t begin_;
};

void put_cloud(Bytes& out, const PointCloud& cloud, std::uint64_t time_us) {
  for (const int byte : {0, 1, 0, 0}) out.push_back(static_cast<std::uint8_t>(byte));
  CdrWriter cdr(out);
  cdr.put(static_cast<std::int32_t>(time_us / 1'000'000));
  cdr.put(static_cast<std::uint32_t>(time_us % 1'000'000 * 1000));
  cdr.put_string("map");
  cdr.put(std::uint32_t{1});
  cdr.put(static_cast<std::uint32_t>(cloud.size()));
  const std::vector<RecordColumn> columns = record_columns(cloud);
  cdr.put(static_cast<std::uint32_t>(columns.size()));
  std::uint32_t step = 0;
  for (const RecordColumn& column : columns) {
    cdr.put_string(column.name);
    cdr.put(step);
    // Colours too are said to be a float, as PCL does, which is what readers expect.
    cdr.put(column.type == RecordColumn::Type::float64 ? kFloat64 : kFloat32);
    cdr.put(std::uint32_t{1});
    step += static_cast<std::uint32_t>(column.bytes());
  }
  const auto bytes = static_cast<std::uint32_t>(step * cloud.size());
  cdr.put(std::uint8_t{0});
  cdr.put(step);
  cdr.put(bytes);
  cdr.put(bytes);
  put_records(cloud, out);
  cdr.put(std::uint8_t{1});
}

void put_schema(Bytes& out) {
  put_record(out, kSchema, [](Bytes& content) {
    ByteWriter(content).put(kId);
    put_string(content, "sensor_msgs/msg/PointCloud2");
    put_string(content, "ros2msg");
    put_string(content, kDefinition);
  });
}

void put_channel(Bytes& out) {
  put_record(out, kChannel, [](Bytes& content) {
    ByteWriter(content).put(kId);
    ByteWriter(content).put(kId);
    put_string(content, "/points");
    put_string(content, "cdr");
    ByteWriter(content).put(std::uint32_t{0});
  });
}

}  // namespace

Result<RecordedFrame> record_frame(const PointCloud& cloud, std::uint64_t time_us) {
  std::uint64_t step = 0;
  for (const RecordColumn& column : record_columns(cloud)) step += column.bytes();
  if (step * cloud.size() > kMostMessageBytes - (1u << 16))
    return fail(ErrorCode::limit, "the frame has too many points for a message of 1 GiB");
  RecordedFrame frame;
  frame.time_ns = 1000 * time_us;
  Bytes records;
  put_record(records, kMessage, [&](Bytes& content) {
    ByteWriter out(content);
    out.put(kId);
    out.put(std::uint32_t{0});
    out.put(frame.time_ns);  // when it was recorded
    out.put(frame.time_ns);  // and published
    put_cloud(content, cloud, time_us);
  });
  frame.unpacked = records.size();
  frame.checksum = static_cast<std::uint32_t>(crc32_z(0, records.data(), records.size()));
  frame.packed.resize(ZSTD_compressBound(records.size()));
  const std::size_t size = ZSTD_compress(frame.packed.data(), frame.packed.size(), records.data(),
                                         records.size(), kZstdLevel);
  if (ZSTD_isError(size)) return fail(ErrorCode::limit, "not enough memory for zstd");
  frame.packed.resize(size);
  return frame;
}

RecordingWriter::RecordingWriter(std::filesystem::path path)
    : path_(std::move(path)), file_(path_, std::ios::binary) {
  Bytes bytes;
  put_bytes(bytes, kMcapMagic.data(), kMcapMagic.size());
  put_record(bytes, kHeader, [](Bytes& content) {
    put_string(content, "ros2");
    put_string(content, "Pointreel " POINTREEL_VERSION);
  });
  put_schema(bytes);
  put_channel(bytes);
  // If that fails, so does the next.
  (void)append(bytes);
}

Result<void> RecordingWriter::append(const Bytes& bytes) {
  if (!file_.write(reinterpret_cast<const char*>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()))) {
    return fail(ErrorCode::io,
                fmt::format("{}: cannot be written: {}", path_.string(), why_not_written(errno)));
  }
  size_ += bytes.size();
  return {};
}

Result<void> RecordingWriter::add(const RecordedFrame& frame) {
  Place place;
  place.time_ns = frame.time_ns;
  place.begin = size_;
  place.packed = frame.packed.size();
  place.unpacked = frame.unpacked;
  Bytes bytes;
  put_record(bytes, kChunk, [&](Bytes& content) {
    ByteWriter out(content);
    out.put(frame.time_ns);
    out.put(frame.time_ns);
    out.put(frame.unpacked);
    out.put(frame.checksum);
    put_string(content, kZstd);
    out.put(place.packed);
    put_bytes(content, frame.packed.data(), frame.packed.size());
  });
  place.bytes = bytes.size();
  put_record(bytes, kMessageIndex, [&](Bytes& content) {
    ByteWriter out(content);
    out.put(kId);
    out.put(std::uint32_t{16});
    out.put(frame.time_ns);
    out.put(std::uint64_t{0});  // the message begins the chunk
  });
  place.index_bytes = bytes.size() - place.bytes;
  TRY(append(bytes));
  places_.push_back(place);
  return {};
}

Bytes RecordingWriter::summary() const {
  Bytes bytes, offsets;
  const auto put_group = [&](Opcode opcode, const auto& write) {
    const std::size_t begin = bytes.size();
    write();
    if (bytes.size() == begin) return;
    put_record(offsets, kSummaryOffset, [&](Bytes& content) {
      ByteWriter out(content);
      out.put(static_cast<std::uint8_t>(opcode));
      out.put(std::uint64_t{size_ + begin});
      out.put(std::uint64_t{bytes.size() - begin});
    });
  };
  put_group(kSchema, [&] { put_schema(bytes); });
  put_group(kChannel, [&] { put_channel(bytes); });
  put_group(kStatistics, [&] {
    put_record(bytes, kStatistics, [&](Bytes& content) {
      ByteWriter out(content);
      out.put(std::uint64_t{places_.size()});  // messages
      out.put(std::uint16_t{1});               // schemas
      out.put(std::uint32_t{1});               // channels
      out.put(std::uint32_t{0});               // attachments
      out.put(std::uint32_t{0});               // metadata
      out.put(static_cast<std::uint32_t>(places_.size()));
      out.put(places_.empty() ? std::uint64_t{0} : places_.front().time_ns);
      out.put(places_.empty() ? std::uint64_t{0} : places_.back().time_ns);
      out.put(std::uint32_t{10});  // bytes of the messages of each channel
      out.put(kId);
      out.put(std::uint64_t{places_.size()});
    });
  });
  put_group(kChunkIndex, [&] {
    for (const Place& place : places_) {
      put_record(bytes, kChunkIndex, [&](Bytes& content) {
        ByteWriter out(content);
        out.put(place.time_ns);
        out.put(place.time_ns);
        out.put(place.begin);
        out.put(place.bytes);
        out.put(std::uint32_t{10});  // bytes of the places of indexes
        out.put(kId);
        out.put(place.begin + place.bytes);
        out.put(place.index_bytes);
        put_string(content, kZstd);
        out.put(place.packed);
        out.put(place.unpacked);
      });
    }
  });
  const std::uint64_t begin = size_, offsets_begin = size_ + bytes.size();
  put_bytes(bytes, offsets.data(), offsets.size());
  put_record(bytes, kFooter, [&](Bytes& content) {
    ByteWriter out(content);
    out.put(begin);
    out.put(offsets_begin);
    out.put(std::uint32_t{0});
  });
  // The checksum is that of everything before it.
  const std::size_t covered = bytes.size() - sizeof(std::uint32_t);
  const auto checksum = static_cast<std::uint32_t>(crc32_z(0, bytes.data(), covered));
  std::memcpy(bytes.data() + covered, &checksum, sizeof(checksum));
  put_bytes(bytes, kMcapMagic.data(), kMcapMagic.size());
  return bytes;
}

Result<void> RecordingWriter::finish() {
  Bytes end;
  put_record(end, kDataEnd, [](Bytes& content) { ByteWriter(content).put(std::uint32_t{0}); });
  TRY(append(end));
  TRY(append(summary()));
  file_.close();
  return file_ ? Result<void>() : append({});
}

}  // namespace pointreel
