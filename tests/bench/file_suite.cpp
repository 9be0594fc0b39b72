#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "codec/files/cloud_file.h"
#include "codec/files/ply.h"
#include "common/base/byte_io.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"
#include "tests/bench/clouds.h"
#include "tests/bench/measure.h"
#include "tests/bench/suites.h"
#include "tests/depth_scene.h"
#include "tests/ros_messages.h"
#include "tests/temporary_folder.h"

namespace pointreel::bench {
namespace {

struct Input {
  std::string name;
  std::filesystem::path path;
  double least_share = 0.0;  ///< bar: of the speed of reading the bytes into memory; 0: none
  double least_rate = 0.0;   ///< bar: MB/s of the file; 0: none
};

void put(Bytes& out, const std::string& text) { out.insert(out.end(), text.begin(), text.end()); }

std::uint32_t packed(const glm::u16vec3& color) {
  return (color.x / 257u) << 16 | (color.y / 257u) << 8 | color.z / 257u;
}

/// As the Point Cloud Library writes PointXYZRGB, or PointXYZ without colours.
Bytes pcd_of(const PointCloud& cloud, bool colors) {
  Bytes bytes;
  put(bytes, fmt::format("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z{}\n"
                         "SIZE 4 4 4{}\nTYPE F F F{}\nCOUNT 1 1 1{}\nWIDTH {}\nHEIGHT 1\n"
                         "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
                         colors ? " rgb" : "", colors ? " 4" : "", colors ? " F" : "",
                         colors ? " 1" : "", cloud.size(), cloud.size()));
  ByteWriter out(bytes);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) out.put(cloud.positions[i][axis]);
    if (colors) out.put(packed(cloud.colors[i]));
  }
  return bytes;
}

/// LAS 1.4 of point format 7, in millimetres, far from zero.
Bytes las_of(const PointCloud& cloud) {
  constexpr std::size_t kHeader = 375, kRecord = 36, kColor = 30;
  Bytes bytes(kHeader + kRecord * cloud.size());
  const auto set = [&](std::size_t at, auto value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  std::memcpy(bytes.data(), "LASF", 4);
  bytes[24] = 1;
  bytes[25] = 4;
  bytes[104] = 7;
  set(94, static_cast<std::uint16_t>(kHeader));
  set(96, static_cast<std::uint32_t>(kHeader));
  set(105, static_cast<std::uint16_t>(kRecord));
  set(247, static_cast<std::uint64_t>(cloud.size()));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    set(131 + 8 * axis, 0.001);
    set(155 + 8 * axis, 500'000.0);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t at = kHeader + kRecord * i;
    for (int axis = 0; axis < 3; ++axis) {
      set(at + 4 * static_cast<std::size_t>(axis),
          static_cast<std::int32_t>(1000.0f * cloud.positions[i][axis]));
      set(at + kColor + 2 * static_cast<std::size_t>(axis), cloud.colors[i][axis]);
    }
  }
  return bytes;
}

/// Messages of 30,000 points as PointXYZRGB, about 10 in each chunk, as rosbag2 records a lidar.
Bytes mcap_of(const PointCloud& cloud, const std::string& compression) {
  constexpr std::size_t kPoints = 30'000, kInChunk = 10;
  constexpr std::uint32_t kStep = 16;
  McapWriter out;
  out.add(McapWriter::schema(1, "sensor_msgs/msg/PointCloud2"));
  out.add(McapWriter::channel(1, 1, "/points"));
  Bytes records;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> index;
  std::uint64_t time_ns = 0;
  for (std::size_t first = 0; first < cloud.size(); first += kPoints) {
    const std::size_t count = std::min(kPoints, cloud.size() - first);
    Bytes data;
    ByteWriter points(data);
    for (std::size_t i = first; i < first + count; ++i) {
      for (int axis = 0; axis < 3; ++axis) points.put(cloud.positions[i][axis]);
      points.put(packed(cloud.colors[i]));
    }
    CdrWriter cdr(false);
    cdr.put(std::int32_t{0});
    cdr.put(std::uint32_t{0});
    cdr.put_text("lidar");
    cdr.put(std::uint32_t{1});
    cdr.put(static_cast<std::uint32_t>(count));
    cdr.put(std::uint32_t{4});
    std::uint32_t offset = 0;
    for (const char* name : {"x", "y", "z", "rgb"}) {
      cdr.put_text(name);
      cdr.put(offset);
      cdr.put(std::uint8_t{7});
      cdr.put(std::uint32_t{1});
      offset += 4;
    }
    cdr.put(std::uint8_t{0});
    cdr.put(kStep);
    cdr.put(static_cast<std::uint32_t>(kStep * count));
    cdr.put_bytes(data);
    cdr.put(std::uint8_t{1});
    index.emplace_back(time_ns, records.size());
    const Bytes message = McapWriter::message(1, time_ns, cdr.bytes());
    records.insert(records.end(), message.begin(), message.end());
    time_ns += 100'000'000;
    if (index.size() < kInChunk && first + count < cloud.size()) continue;
    out.add_chunk(records, compression);
    out.add_index(1, index);
    records.clear();
    index.clear();
  }
  out.end();
  return out.bytes();
}

/// A camera of 640 x 480 pixels, whose depth is noisy by some steps and whose colours are grainy,
/// as a folder of PNG files.
void write_depth_folder(const std::filesystem::path& folder, int frames) {
  const CameraIntrinsics camera = depth_scene::camera(640);
  std::mt19937 random(1);
  const auto put = [&](const std::string& name, const std::string& content) {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << content;
  };
  put("intrinsic.json", depth_scene::intrinsics(camera));
  for (int frame = 0; frame < frames; ++frame) {
    DepthPicture depth = depth_scene::depth(camera, frame);
    for (std::uint16_t& value : depth.values)
      value = static_cast<std::uint16_t>(value + random() % 5 - 2);
    ColorPicture color = depth_scene::color(camera, frame);
    for (std::uint8_t& value : color.rgb) value = static_cast<std::uint8_t>(value + random() % 9);
    put(fmt::format("depth/{}.png", frame), depth_scene::png(depth));
    put(fmt::format("color/{}.png", frame), depth_scene::png(color));
  }
}

/// Reads all frames of a file, and counts their points.
Result<std::size_t> read_points_of(const std::filesystem::path& path) {
  const CloudSequence sequence = TRY(list_cloud_frames({path}));
  std::size_t points = 0;
  for (const CloudFrame& frame : sequence.frames)
    points += TRY(read_cloud_frame(frame)).cloud.size();
  return points;
}

/// The file itself, or the files of a folder.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  return files;
}

double megabytes_of(const std::filesystem::path& path) {
  double bytes = 0.0;
  for (const std::filesystem::path& file : files_of(path))
    bytes += static_cast<double>(std::filesystem::file_size(file));
  return 1e-6 * bytes;
}

/// Milliseconds; the bytes are kept until then, as those of a cloud are.
double read_bytes_ms(const std::filesystem::path& path) {
  const double begin = now_ms();
  std::vector<Bytes> all;
  for (const std::filesystem::path& file : files_of(path)) {
    std::ifstream in(file, std::ios::binary);
    Bytes& bytes = all.emplace_back(std::filesystem::file_size(file));
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  return now_ms() - begin;
}

nlohmann::json measure_file(const Input& input, int runs, std::vector<Bar>& bars) {
  std::vector<double> plain, read;
  std::size_t points = 0;
  // In turns, so that both see the same machine.
  for (int i = 0; i < runs; ++i) {
    plain.push_back(read_bytes_ms(input.path));
    const double begin = now_ms();
    const auto loaded = read_points_of(input.path);
    read.push_back(now_ms() - begin);
    if (!loaded) return {{"error", loaded.error().message}};
    points = *loaded;
  }
  const double megabytes = megabytes_of(input.path);
  const double plain_ms = summarise(plain).median, read_ms = summarise(read).median;
  const double share = plain_ms / read_ms;
  print(
      "  {:<28} {:>9} points {:>7.1f} MB   bytes {:>7.1f} ms   cloud {:>7.1f} ms   {:>6.0f} MB/s "
      "  {:>5.1f} million points/s   {:>5.0f} %\n",
      input.name, points, megabytes, plain_ms, read_ms, 1e3 * megabytes / read_ms,
      1e-3 * static_cast<double>(points) / read_ms, 100.0 * share);
  if (input.least_share > 0.0)
    bars.push_back({input.name + ": of the speed of reading the bytes", 100.0 * share, "%",
                    100.0 * input.least_share, true});
  if (input.least_rate > 0.0)
    bars.push_back(
        {input.name + ": speed", 1e3 * megabytes / read_ms, "MB/s", input.least_rate, true});
  return {{"name", input.name},
          {"points", points},
          {"megabytes", megabytes},
          {"bytes_ms", plain_ms},
          {"cloud_ms", read_ms}};
}

}  // namespace

nlohmann::json run_files(const SuiteOptions& options) {
  const TemporaryFolder folder;
  const PointCloud cloud = scan_like_cloud(options.quick ? 300'000 : 3'000'000);
  std::vector<Input> inputs;
  const auto add = [&](const char* name, const char* file, const Bytes& bytes, double least_share,
                       double least_rate = 0.0) {
    inputs.push_back({name, folder.path() / file, least_share, least_rate});
    return write_file(inputs.back().path, bytes);
  };
  for (const Result<void>& written :
       {add("PCD, positions", "a.pcd", pcd_of(cloud, false), 0.8),
        add("PCD, positions and colours", "b.pcd", pcd_of(cloud, true), 0.8),
        add("LAS, point format 7", "c.las", las_of(cloud), 0.8),
        add("PLY, binary", "d.ply", ply_bytes(cloud), 0.0),
        add("MCAP, zstd", "e.mcap", mcap_of(cloud, "zstd"), 0.0, 300.0),
        add("MCAP, lz4", "f.mcap", mcap_of(cloud, "lz4"), 0.0, 300.0),
        add("MCAP, not compressed", "g.mcap", mcap_of(cloud, ""), 0.0, 300.0)}) {
    if (!written) return {{"error", written.error().message}};
  }
  const int frames = options.quick ? 3 : 10;
  write_depth_folder(folder / "depth", frames);
  inputs.push_back({"depth, PNG", folder / "depth"});
  if (depth_scene::write_video(folder / "depth", folder / "h.mkv", 30))
    inputs.push_back({"depth, ffv1 and MJPEG", folder / "h.mkv"});
  for (const std::filesystem::path& file : options.files)
    inputs.push_back({file.filename().string(), file});
  print("Reading files that are in the page cache, on one thread\n");
  std::vector<Bar> bars;
  nlohmann::json rows = nlohmann::json::array();
  for (const Input& input : inputs) {
    rows.push_back(measure_file(input, options.quick ? 5 : 21, bars));
    if (rows.back().contains("error")) return rows.back();
  }
  print(bars, options.quick);
  return {{"files", rows}, {"bars", to_json(bars, options.quick)}};
}

}  // namespace pointreel::bench
