#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <zstd.h>

#include "codec/core/scalar_fields.h"
#include "codec/files/cloud_file.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "tests/bench/measure.h"
#include "tests/bench/suites.h"
#include "tests/bench/table.h"

namespace pointreel::bench {
namespace {

/// Numbers such as scanners give: the strength of the echo, of 12 bits and with noise; the class of
/// what was hit; and a temperature, which is smooth.
void add_fields(PointCloud& cloud) {
  Random random(11, 0);
  const Box box = bounds(cloud);
  ScalarField intensity{"intensity", {}}, kind{"class", {}}, temperature{"temperature", {}};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 color =
        cloud.has_colors() ? glm::vec3(cloud.colors[i]) / 65535.0f : glm::vec3(0.5f);
    const float luma = 0.2126f * color.r + 0.7152f * color.g + 0.0722f * color.b;
    const float noise = 0.02f * static_cast<float>(random.normal());
    intensity.values.push_back(std::floor(4095.0f * std::clamp(luma + noise, 0.0f, 1.0f)));
    const double height = (cloud.world(i).y - box.min.y) / (box.max.y - box.min.y);
    kind.values.push_back(1.0f + std::floor(4.999f * static_cast<float>(height)));
    temperature.values.push_back(36.0f - 6.0f * static_cast<float>(height) - 3.0f * luma);
  }
  cloud.scalars = {std::move(intensity), std::move(kind), std::move(temperature)};
}

/// Bits for each value of what zstd makes of the floats, in the order of the file.
double zstd_bits(const std::vector<float>& values) {
  const std::size_t size = values.size() * sizeof(float);
  Bytes packed(ZSTD_compressBound(size));
  const std::size_t bytes = ZSTD_compress(packed.data(), packed.size(), values.data(), size, 19);
  return 8.0 * static_cast<double>(bytes) / static_cast<double>(values.size());
}

/// A cloud encoded and decoded, on one thread.
struct Coded {
  EncodedFrame frame;
  double encode_ms = 0.0, decode_ms = 0.0;
};

Result<Coded> code(const PointCloud& cloud, const Cube& cube, int runs) {
  Coded coded{TRY(encode_octree(cloud, cube)), 0.0, 0.0};
  coded.encode_ms = measure(runs, [&] { return encode_octree(cloud, cube).has_value(); }).min;
  const auto views = layer_views(coded.frame.layers);
  TRY(decode_octree(views));
  coded.decode_ms = measure(runs, [&] { return decode_octree(views).has_value(); }).min;
  return coded;
}

Result<nlohmann::json> measure_cloud(const std::string& name, PointCloud cloud, int runs,
                                     Table& table) {
  const Cube cube = bounding_cube(bounds(cloud));
  const std::vector<ScalarField> fields = std::exchange(cloud.scalars, {});
  const Coded without = TRY(code(cloud, cube, runs));
  nlohmann::json rows = nlohmann::json::array();
  for (const ScalarField& field : fields) {
    cloud.scalars = {field};
    const Coded with = TRY(code(cloud, cube, runs));
    const double bits = 8.0 * static_cast<double>(with.frame.scalar_bytes()) /
                        static_cast<double>(with.frame.coded_points);
    const double raw = zstd_bits(field.values);
    const double encode = with.encode_ms - without.encode_ms;
    const double decode = with.decode_ms - without.decode_ms;
    table.row({rows.empty() ? fmt::format("{}, {} points", name, cloud.size()) : "", field.name,
               fmt::format("{:.2f}", bits), fmt::format("{:.2f}", raw),
               fmt::format("{:.1f}", encode), fmt::format("{:.1f}", decode)});
    rows.push_back({{"cloud", name},
                    {"field", field.name},
                    {"bits", bits},
                    {"zstd_bits", raw},
                    {"encode_ms", encode},
                    {"decode_ms", decode},
                    {"frame_decode_ms", without.decode_ms}});
  }
  return rows;
}

Result<nlohmann::json> measure_all(const SuiteOptions& options) {
  Table table(
      {"cloud", "field", "bits", "zstd -19 of the floats, bits", "encode, ms", "decode, ms"});
  nlohmann::json rows = nlohmann::json::array();
  const int runs = options.quick ? 3 : 9;
  const auto add = [&](const std::string& name, PointCloud cloud) -> Result<void> {
    if (!cloud.has_scalars()) add_fields(cloud);
    for (nlohmann::json& row : TRY(measure_cloud(name, std::move(cloud), runs, table)))
      rows.push_back(std::move(row));
    return {};
  };
  for (const char* name : {"kick", "soccer-shoot"})
    TRY(add(name, TRY(sequence_frame(*find_motion(name), {}, 0))));
  for (const std::filesystem::path& file : options.files)
    TRY(add(file.filename().string(), TRY(read_cloud_file(file)).cloud));
  pointreel::print_lines(table.text());
  return nlohmann::json{{"scalars", std::move(rows)}, {"bars", nlohmann::json::array()}};
}

}  // namespace

nlohmann::json run_scalars(const SuiteOptions& options) {
  auto report = measure_all(options);
  if (!report) return {{"error", report.error().message}};
  return *std::move(report);
}

}  // namespace pointreel::bench
