#include "datasets_synthetic/hard_values.h"

#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pointreel {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A ball in which each of `values` replaces one coordinate of one point; these points are spread
/// over the cloud.
PlyTable spoilt_ball(const std::vector<double>& values) {
  PlyTable table = ball(kBallPoints);
  for (std::size_t i = 0; i < values.size(); ++i) {
    table.rows[(i * kBallPoints) / values.size() + 7][i % 3] = values[i];
  }
  return table;
}

void add_positions(CaseList& list) {
  constexpr const char* kNotFinite = "NaN or infinite position";
  const auto add_spoilt = [&](const char* file, const char* title, const PlyTable& table,
                              PlyFormat format = PlyFormat::little_endian) {
    list.add(kNotFinite, file, title, table, expect_table(table), format);
  };
  add_spoilt("position_nan.ply", "A ball of which 9 points have a NaN for a coordinate",
             spoilt_ball(std::vector<double>(9, kNan)));
  add_spoilt("position_infinite.ply", "A ball of which 8 points are at +-infinity along one axis",
             spoilt_ball({kInf, -kInf, kInf, -kInf, kInf, kInf, -kInf, -kInf}));
  add_spoilt("position_nan_ascii.ply", "The words nan, -nan, inf and -inf among the coordinates",
             spoilt_ball({kNan, -kNan, kInf, -kInf}), PlyFormat::ascii);
  PlyTable first = ball(kBallPoints);
  first.rows.front()[0] = kNan;
  first.rows.back()[2] = kNan;
  add_spoilt("position_nan_first_and_last.ply", "The first and the last point are NaN", first);
  add_spoilt("position_nan_all.ply", "Five points, all of them NaN",
             positions(std::vector<glm::dvec3>(5, glm::dvec3(kNan))));

  // These doubles are finite, but beyond the range of floats.
  PlyTable beyond = ball(kBallPoints, {1e6, 0, 1e6}, PlyType::float64);
  HardExpectation expect = expect_table(ball(kBallPoints, {1e6, 0, 1e6}, PlyType::float64));
  for (const double value : {1e300, -4e38, 1.7976931348623157e308}) {
    beyond.rows.push_back(beyond.rows.front());
    beyond.rows.back()[1] = value;
    ++expect.dropped;
  }
  list.add(kNotFinite, "position_beyond_float.ply",
           "A ball about (1e6, 0, 1e6) in doubles and three points that no float can hold", beyond,
           expect);

  constexpr const char* kFarGroup = "far coordinates";
  const std::pair<const char*, double> offsets[] = {{"1e3", 1e3}, {"1e6", 1e6}, {"1e9", 1e9}};
  for (const auto& [name, offset] : offsets) {
    const PlyTable table = ball(kBallPoints, {offset, -0.5 * offset, offset}, PlyType::float64);
    list.add(kFarGroup, fmt::format("offset_{}_double.ply", name),
             fmt::format("A ball of 1 unit about ({0}, -{0} / 2, {0}) in doubles", name), table,
             expect_table(table));
  }
  const PlyTable rough = ball(kBallPoints, {1e6, 0, 1e6});
  list.add(kFarGroup, "offset_1e6_float.ply",
           "The ball about (1e6, 0, 1e6) in floats, which are 1/16 apart there", rough,
           expect_table(rough));
  const PlyTable lost = ball(kBallPoints, glm::dvec3(1e9));
  list.add(kFarGroup, "offset_1e9_float.ply",
           "The ball about (1e9, 1e9, 1e9) in floats: one point is left of it", lost,
           with_tree(expect_table(lost), 0, 1));
  PlyTable millimetres;
  millimetres.add_columns(PlyType::int32, {"x", "y", "z"});
  for (const std::vector<double>& p : ball(kBallPoints).rows) {
    std::vector<double> row;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row.push_back(static_cast<double>(static_cast<int>(1700.0 * p[axis])) + 450000000.0);
    }
    millimetres.rows.push_back(row);
  }
  list.add(kFarGroup, "offset_millimetres_int.ply",
           "A ball of 1.7 m as integer millimetres on a national grid, 450 km from its zero",
           millimetres, expect_table(millimetres));
}

void add_normals(CaseList& list) {
  constexpr const char* kRow = "unusable normal";
  const auto set_normal = [](PlyTable& table, std::size_t row, double x, double y, double z) {
    table.rows[row][3] = x;
    table.rows[row][4] = y;
    table.rows[row][5] = z;
  };
  const auto add = [&](const char* file, const char* title, const PlyTable& table,
                       std::size_t unknown) {
    HardExpectation expect = expect_table(table);
    expect.unknown_normals = unknown;
    expect.normals = unknown < kBallPoints;  // where none is usable, they count as missing
    list.add(kRow, file, title, table, expect);
  };
  PlyTable zero = ball(kBallPoints), nan = zero, lengths = zero, none = zero;
  for (std::size_t i = 0; i < 300; ++i) set_normal(zero, i, 0, 0, 0);
  add("normal_zero.ply", "A ball whose upper 300 points have zero for a normal", zero, 300);
  for (std::size_t i = 0; i < 300; ++i) nan.rows[i][3 + i % 3] = kNan;
  for (std::size_t i = 300; i < 310; ++i) nan.rows[i][3 + i % 3] = kInf;
  add("normal_nan.ply", "A ball with 300 NaN normals at its top and 10 infinite ones below them",
      nan, 310);
  for (std::size_t i = 0; i < kBallPoints; ++i) {
    const double scale = i % 3 == 0 ? 1e-30 : i % 3 == 1 ? 127.0 : 1e30;
    for (std::size_t axis = 3; axis < 6; ++axis) lengths.rows[i][axis] *= scale;
  }
  add("normal_lengths.ply", "Normals of the lengths 1e-30, 127 and 1e30", lengths, 0);
  for (std::size_t i = 0; i < kBallPoints; ++i) set_normal(none, i, 0, 0, 0);
  add("normal_zero_all.ply", "A ball all of whose normals are zero", none, kBallPoints);
}

void add_radii(CaseList& list) {
  constexpr const char* kRow = "unusable radius";
  constexpr double kUsual = 0.06;
  const auto with_radii = [](auto&& radius) {
    PlyTable table = ball(kBallPoints);
    std::size_t i = 0;
    table.add_columns(PlyType::float32, {"radius"},
                      [&](std::size_t) { return std::vector<double>{radius(i++)}; });
    return table;
  };
  const auto add = [&](const char* file, const char* title, const PlyTable& table, std::size_t bad,
                       double largest) {
    HardExpectation expect = expect_table(table);
    expect.bad_radii = bad;
    expect.radii = bad < kBallPoints;
    if (expect.radii) expect.largest_radius = largest;
    list.add(kRow, file, title, table, expect);
  };
  const auto every_tenth = [&](double value) {
    return with_radii([=](std::size_t i) { return i % 10 == 3 ? value : kUsual; });
  };
  // Neighbouring points are 0.04 apart.
  add("radius_zero.ply", "Every tenth radius is zero", every_tenth(0.0), 200, 0.0601);
  add("radius_negative.ply", "Every tenth radius is -0.02", every_tenth(-kUsual), 200, 0.0601);
  add("radius_nan.ply", "Every tenth radius is NaN", every_tenth(kNan), 200, 0.0601);
  add("radius_huge.ply", "Five radii are 1e20 and one is infinite", with_radii([](std::size_t i) {
        return i % 400 == 11 ? 1e20 : i == 1500 ? kInf : kUsual;
      }),
      6, 0.0601);
  add("radius_none_usable.ply", "Radii that are zero, negative, NaN or infinite, all of them",
      with_radii([](std::size_t i) {
        return i % 4 == 0 ? 0.0 : i % 4 == 1 ? -1.0 : i % 4 == 2 ? kNan : kInf;
      }),
      kBallPoints, 0.0);
}

void add_colors(CaseList& list) {
  struct Kind {
    const char* file;
    const char* row;
    PlyType type;
    double full;  // the largest value of a channel
  };
  const Kind kinds[] = {{"color_uchar.ply", "8-bit colours", PlyType::uint8, 255.0},
                        {"color_ushort.ply", "16-bit colours", PlyType::uint16, 65535.0},
                        {"color_float.ply", "float colours", PlyType::float32, 1.0},
                        {"color_double.ply", "float colours", PlyType::float64, 1.0}};
  for (const Kind& kind : kinds) {
    PlyTable table = ball(kBallPoints);
    for (std::size_t i = 6; i < 9; ++i) table.columns[i].type = kind.type;
    for (std::vector<double>& row : table.rows) {
      for (std::size_t i = 6; i < 9; ++i) row[i] *= kind.full / 255.0;
    }
    for (std::size_t i = 6; i < 9; ++i) {
      table.rows.front()[i] = i == 6 ? kind.full : i == 7 ? 0.2 * kind.full : 0.0;
    }
    HardExpectation expect = expect_table(table);
    expect.first_color = glm::u16vec3(65535, 13107, 0);
    list.add(kind.row, kind.file, fmt::format("Colours of type {}", name_of(kind.type)), table,
             expect);
  }
  PlyTable wild = ball(4);
  for (std::size_t i = 6; i < 9; ++i) wild.columns[i].type = PlyType::float32;
  wild.rows = {wild.rows[0], wild.rows[1]};
  wild.rows[0][6] = 1.5, wild.rows[0][7] = kNan, wild.rows[0][8] = -kInf;
  wild.rows[1][6] = wild.rows[1][7] = wild.rows[1][8] = 1e6;
  HardExpectation expect = expect_table(wild);
  expect.first_color = glm::u16vec3(65535, 0, 0);
  list.add("float colours", "color_float_wild.ply",
           "Float colours of 1.5, NaN, -infinity, and a million, where 1 is white", wild, expect);
  const PlyTable bare = ball(kBallPoints, glm::dvec3(0.0), PlyType::float32, false);
  list.add("no colours", "color_none.ply", "Positions and nothing else", bare, expect_table(bare));
  PlyTable alpha = ball(kBallPoints);
  alpha.add_columns(PlyType::uint8, {"alpha"}, [](std::size_t row) {
    return std::vector<double>{static_cast<double>(row % 256)};
  });
  list.add("8-bit colours", "color_alpha.ply", "Colours with alpha, some of them transparent",
           alpha, expect_table(alpha));
  PlyTable partial = ball(kBallPoints);
  partial.columns[8].name = "azure";
  partial.columns[5].name = "n3";
  expect = expect_table(partial);
  expect.colors = expect.normals = false;
  list.add("no colours", "color_incomplete.ply", "Red and green without blue, nx and ny without nz",
           partial, expect);
  PlyTable named = ball(kBallPoints);
  expect = expect_table(named);
  const char* names[] = {"normal_x",    "normal_y",      "normal_z",
                         "diffuse_red", "diffuse_green", "diffuse_blue"};
  for (std::size_t i = 0; i < 6; ++i) named.columns[3 + i].name = names[i];
  list.add("8-bit colours", "color_diffuse.ply", "normal_x and diffuse_red for nx and red", named,
           expect);
}

}  // namespace

void add_value_cases(std::vector<HardCase>& cases) {
  CaseList list(cases, "ingest");
  add_positions(list);
  add_normals(list);
  add_radii(list);
  add_colors(list);
}

}  // namespace pointreel
