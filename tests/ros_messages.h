#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "pointreel/bytes.h"

/// Messages and recordings of ROS 2, made independently of what reads them.
namespace pointreel {

/// Appends numbers aligned to their size.
class CdrWriter {
 public:
  explicit CdrWriter(bool big_endian) : big_endian_(big_endian) {
    bytes_ = {0, static_cast<std::uint8_t>(big_endian ? 0 : 1), 0, 0};
  }
  template <class T>
  void put(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    std::uint8_t raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big_endian_) std::reverse(raw, raw + sizeof(T));
    bytes_.insert(bytes_.end(), raw, raw + sizeof(T));
  }
  void put_text(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  void put_bytes(const Bytes& bytes) {
    put(static_cast<std::uint32_t>(bytes.size()));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  bool big_endian_;
  Bytes bytes_;
};

/// A PointCloud2 with the fields z, x, intensity, y, rgb in this order.
struct CloudMessage {
  struct Field {
    std::string name;
    std::uint32_t offset = 0;
    std::uint8_t type = 7;
    std::uint32_t count = 1;
  };
  std::vector<Field> fields;
  std::uint32_t width = 0, height = 1, point_step = 0, row_step = 0, row_padding = 0;
  bool big_endian = false;
  std::vector<std::vector<float>> points;  ///< x, y, z

  Bytes data() const {
    Bytes data;
    const auto put = [&](auto value) {
      std::uint8_t raw[sizeof(value)];
      std::memcpy(raw, &value, sizeof(value));
      if (big_endian) std::reverse(raw, raw + sizeof(value));
      data.insert(data.end(), raw, raw + sizeof(value));
    };
    for (const auto& p : points) {
      put(p[2]);
      put(p[0]);
      put(std::uint16_t{77});
      put(static_cast<double>(p[1]));
      put(std::uint32_t{0xff102030});
      data.resize(data.size() + 8 + row_padding);
    }
    return data;
  }

  Bytes cdr() const {
    CdrWriter out(big_endian);
    out.put(std::int32_t{1700000000});
    out.put(std::uint32_t{5});
    out.put_text("lidar");
    out.put(height);
    out.put(width);
    out.put(static_cast<std::uint32_t>(fields.size()));
    for (const Field& field : fields) {
      out.put_text(field.name);
      out.put(field.offset);
      out.put(field.type);
      out.put(field.count);
    }
    out.put(static_cast<std::uint8_t>(big_endian));
    out.put(point_step);
    out.put(row_step);
    out.put_bytes(data());
    out.put(std::uint8_t{1});
    return out.bytes();
  }
};

inline CloudMessage two_points() {
  CloudMessage message;
  message.fields = {{"z", 0, 7, 1},  {"x", 4, 7, 1},    {"intensity", 8, 4, 1},
                    {"y", 10, 8, 1}, {"rgb", 18, 7, 1}, {"histogram", 22, 7, 2}};
  message.points = {{1, 2, 3}, {4, 5, 6}};
  message.width = 2;
  message.point_step = 30;
  message.row_step = 60;
  return message;
}

/// Writes MCAP.
class McapWriter {
 public:
  template <class T>
  static void put(Bytes& out, T value) {
    const auto* raw = reinterpret_cast<const std::uint8_t*>(&value);
    out.insert(out.end(), raw, raw + sizeof(T));
  }
  static void put_text(Bytes& out, const std::string& text) {
    put(out, static_cast<std::uint32_t>(text.size()));
    out.insert(out.end(), text.begin(), text.end());
  }
  static Bytes record(std::uint8_t opcode, const Bytes& content) {
    Bytes out{opcode};
    put(out, static_cast<std::uint64_t>(content.size()));
    out.insert(out.end(), content.begin(), content.end());
    return out;
  }

  static Bytes schema(std::uint16_t id, const std::string& name) {
    Bytes content;
    put(content, id);
    put_text(content, name);
    put_text(content, "ros2msg");
    put_text(content, "");
    return record(3, content);
  }
  static Bytes channel(std::uint16_t id, std::uint16_t schema, const std::string& topic,
                       const std::string& encoding = "cdr") {
    Bytes content;
    put(content, id);
    put(content, schema);
    put_text(content, topic);
    put_text(content, encoding);
    put(content, std::uint32_t{0});
    return record(4, content);
  }
  static Bytes message(std::uint16_t channel, std::uint64_t time_ns, const Bytes& data) {
    Bytes content;
    put(content, channel);
    put(content, std::uint32_t{0});
    put(content, time_ns);
    put(content, time_ns);
    content.insert(content.end(), data.begin(), data.end());
    return record(5, content);
  }

  void add(const Bytes& record) { bytes_.insert(bytes_.end(), record.begin(), record.end()); }

  /// `unpacked`: what the chunk says about its size, if not the truth.
  void add_chunk(const Bytes& records, const std::string& compression, std::uint64_t unpacked = 0,
                 bool good_checksum = true) {
    Bytes packed = records;
    if (compression == "zstd") {
      packed.resize(ZSTD_compressBound(records.size()));
      packed.resize(ZSTD_compress(packed.data(), packed.size(), records.data(), records.size(), 1));
    } else if (compression == "lz4") {
      packed.resize(LZ4F_compressFrameBound(records.size(), nullptr));
      packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), records.data(), records.size(),
                                       nullptr));
    }
    Bytes content;
    put(content, std::uint64_t{0});
    put(content, std::uint64_t{0});
    put(content, unpacked == 0 ? static_cast<std::uint64_t>(records.size()) : unpacked);
    const auto crc = static_cast<std::uint32_t>(crc32_z(0, records.data(), records.size()));
    put(content, good_checksum ? crc : crc ^ 1u);
    put_text(content, compression);
    put(content, static_cast<std::uint64_t>(packed.size()));
    content.insert(content.end(), packed.begin(), packed.end());
    add(record(6, content));
  }
  void add_index(std::uint16_t channel,
                 const std::vector<std::pair<std::uint64_t, std::uint64_t>>& entries) {
    Bytes content;
    put(content, channel);
    put(content, static_cast<std::uint32_t>(16 * entries.size()));
    for (const auto& [time, offset] : entries) {
      put(content, time);
      put(content, offset);
    }
    add(record(7, content));
  }
  void end() { add(record(2, Bytes(20))), put_raw("\x89MCAP0\r\n", 8); }

  const Bytes& bytes() const { return bytes_; }

 private:
  void put_raw(const char* text, std::size_t size) {
    bytes_.insert(bytes_.end(), text, text + size);
  }
  static Bytes magic() { return {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'}; }

  Bytes bytes_ = magic();
};

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace pointreel
