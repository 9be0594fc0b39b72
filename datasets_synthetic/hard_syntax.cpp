#include "datasets_synthetic/hard_syntax.h"

#include <array>
#include <utility>

#include <fmt/format.h>

namespace pointreel {
namespace {

constexpr std::array kFormats{PlyFormat::ascii, PlyFormat::little_endian, PlyFormat::big_endian};
constexpr std::array kTypes{PlyType::int8,  PlyType::uint8,  PlyType::int16,   PlyType::uint16,
                            PlyType::int32, PlyType::uint32, PlyType::float32, PlyType::float64};
constexpr std::array kFormatNames{"ascii", "little", "big"};

const char* name_of(PlyFormat format) { return kFormatNames[static_cast<std::size_t>(format)]; }

/// Three points; their positions do not matter.
PlyTable three() { return positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 2}}); }

/// An ascii file of three() whose header has the given lines between the format and end_header.
std::string ascii_with(const std::string& header) {
  return ply_begin(PlyFormat::ascii) + header + "end_header\n" +
         ply_rows(three(), PlyFormat::ascii);
}

void add_formats(CaseList& list) {
  for (const PlyFormat format : kFormats) {
    const PlyTable table = ball(kBallPoints);
    const char* row = format == PlyFormat::ascii           ? "ascii"
                      : format == PlyFormat::little_endian ? "little endian"
                                                           : "big endian";
    list.add(row, fmt::format("format_{}.ply", name_of(format)),
             fmt::format("A ball with normals and colours, {}: the same in three formats", row),
             ply_text(table, format), expect_table(table));
  }
  const PlyTable doubles = ball(kBallPoints, glm::dvec3(0.1, 0.2, 0.3), PlyType::float64);
  for (const PlyFormat format : kFormats) {
    list.add("double positions", fmt::format("double_{}.ply", name_of(format)),
             "A ball with positions in doubles", ply_text(doubles, format), expect_table(doubles));
  }
  // A grid that fits every type and has a point at the largest value of a signed byte.
  std::vector<glm::dvec3> grid;
  for (int i = 0; i < 512; ++i) {
    const glm::ivec3 cell(i % 8, (i / 8) % 8, i / 64);
    grid.push_back(glm::dvec3(cell) * 18.0 + 1.0);
  }
  for (const PlyType type : kTypes) {
    for (const bool sized : {false, true}) {
      PlyTable table = positions(grid, type);
      std::string text = ply_text(table, PlyFormat::big_endian);
      if (sized) {
        for (const char* axis : {" x\n", " y\n", " z\n"}) {
          const std::string usual = fmt::format("{}{}", name_of(type), axis);
          text.replace(text.find(usual), usual.size(),
                       fmt::format("{}{}", name_of(type, true), axis));
        }
      }
      list.add("scalar types", fmt::format("type_{}.ply", name_of(type, sized)),
               fmt::format("Positions of type {}, big endian", name_of(type, sized)), text,
               expect_table(table));
    }
  }
  for (const PlyFormat format : kFormats) {
    PlyTable table;
    table.rows.resize(kBallPoints);
    const PlyTable points = ball(kBallPoints);
    for (std::size_t i = 0; i < 3; ++i) {
      for (const PlyType type : kTypes) {
        table.add_columns(
            type, {fmt::format("{}_before_{}", name_of(type), "xyz"[i])},
            [](std::size_t row) { return std::vector<double>{static_cast<double>(row % 100)}; });
      }
      table.add_columns(PlyType::float32, {std::string(1, "xyz"[i])},
                        [&](std::size_t row) { return std::vector<double>{points.rows[row][i]}; });
    }
    list.add("scalar types", fmt::format("type_extra_{}.ply", name_of(format)),
             "Properties of every type that nobody asked for around x, y and z",
             ply_text(table, format), expect_table(table));
  }
}

/// Vertices with a list property, between faces and edges.
std::string with_lists(PlyFormat format, const PlyTable& vertices) {
  const auto number = [format](PlyType type, double value) {
    return format == PlyFormat::ascii ? fmt::format("{} ", static_cast<int>(value))
                                      : ply_value(type, format, value);
  };
  std::string text = ply_begin(format) +
                     "element face 3\nproperty list uchar int vertex_indices\n"
                     "property uchar flags\n" +
                     ply_declaration(vertices) +
                     "property list ushort double weights\n"
                     "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n";
  for (int face = 0; face < 3; ++face) {  // a triangle, a face without corners, and a hexagon
    const int corners = face == 0 ? 3 : face == 1 ? 0 : 6;
    text += number(PlyType::uint8, corners);
    for (int i = 0; i < corners; ++i) text += number(PlyType::int32, i);
    text += number(PlyType::uint8, 9);
    if (format == PlyFormat::ascii) text += '\n';
  }
  PlyTable row = vertices;
  for (std::size_t i = 0; i < vertices.rows.size(); ++i) {
    row.rows = {vertices.rows[i]};
    std::string line = ply_rows(row, format, " ");
    line += number(PlyType::uint16, static_cast<double>(i % 4));
    for (std::size_t k = 0; k < i % 4; ++k) line += number(PlyType::float64, 7.0);
    if (format == PlyFormat::ascii) line += '\n';
    text += line;
  }
  for (int i = 0; i < 4; ++i) text += number(PlyType::int32, i);
  return text;
}

void add_lists(CaseList& list) {
  const PlyTable table = ball(kBallPoints);
  for (const PlyFormat format : kFormats) {
    list.add("list properties", fmt::format("lists_{}.ply", name_of(format)),
             "Faces before the vertices, a list in each vertex, edges behind them",
             with_lists(format, table), expect_table(table));
  }
  std::string mesh = ply_begin(PlyFormat::little_endian) + ply_declaration(table) +
                     "element face 1000\nproperty list uchar uint vertex_index\nend_header\n" +
                     ply_rows(table, PlyFormat::little_endian);
  for (int face = 0; face < 1000; ++face) {
    mesh += ply_value(PlyType::uint8, PlyFormat::little_endian, 3);
    for (int i = 0; i < 3; ++i) {
      mesh += ply_value(PlyType::uint32, PlyFormat::little_endian, face + i);
    }
  }
  list.add("faces", "faces_mesh.ply", "A mesh: vertices and triangles", mesh, expect_table(table));
  list.add("faces", "faces_only.ply", "Faces without a vertex element",
           ply_begin(PlyFormat::ascii) +
               "element face 1\nproperty list uchar int vertex_indices\nend_header\n3 0 1 2\n",
           expect_error({"vertex"}));
  list.add("list properties", "list_as_position.ply", "x is a list",
           ply_begin(PlyFormat::ascii) +
               "element vertex 1\nproperty list uchar float x\nproperty float y\n"
               "property float z\nend_header\n1 0 0 0\n",
           expect_error({"line 3", "vertex", "x"}));
  const std::string lists = "element face 1\nproperty list char int corners\n" +
                            ply_declaration(three()) + "end_header\n";
  list.add("list properties", "list_negative_length.ply", "A list of -1 corners",
           ply_begin(PlyFormat::little_endian) + lists + "\xff" +
               ply_rows(three(), PlyFormat::little_endian),
           expect_error({"byte", "corners", "face 0", "negative"}));
  list.add("list properties", "list_negative_length_ascii.ply", "A list of -1 corners, ascii",
           ply_begin(PlyFormat::ascii) + lists + "-1\n" + ply_rows(three(), PlyFormat::ascii),
           expect_error({"line 10", "corners", "face 0", "-1"}));
  list.add(
      "list properties", "list_float_length.ply", "A list whose length is a float",
      ascii_with("element face 0\nproperty list float int corners\n" + ply_declaration(three())),
      expect_error({"line 4", "corners", "float"}));
  list.add("list properties", "list_longer_than_the_file.ply", "A list of 4294967295 doubles",
           ply_begin(PlyFormat::big_endian) +
               "element face 1\nproperty list uint double corners\n" + ply_declaration(three()) +
               "end_header\n\xff\xff\xff\xff" + ply_rows(three(), PlyFormat::big_endian),
           expect_error({"byte", "corners", "face 0"}));
}

void add_text(CaseList& list) {
  const PlyTable table = ball(kBallPoints);
  const HardExpectation expect = expect_table(table);
  for (const PlyFormat format : kFormats) {
    list.add("CRLF", fmt::format("crlf_{}.ply", name_of(format)), "Lines that end in CR LF",
             ply_text(table, format, "\r\n"), expect);
  }
  const std::string body = ply_rows(table, PlyFormat::ascii);
  list.add("comments", "comments.ply",
           "Comments that look like a header, are empty or are no text; obj_info; empty lines",
           "ply\ncomment end_header\nformat ascii 1.0\ncomment\ncomment element vertex 7\n"
           "obj_info num_cols 512\n\ncomment \xff\xfe\x80 \xc3\xa9\n" +
               ply_declaration(table) + "comment property float w\nend_header\n" + body,
           expect);
  list.add("comments", "comment_long.ply", "A comment of a million characters",
           ply_begin(PlyFormat::ascii) + "comment " + std::string(1000000, '-') + "\n" +
               ply_declaration(table) + "end_header\n" + body,
           expect);
  list.add("comments", "blanks.ply", "Tabs, double blanks, numbers across lines, no last line end",
           "ply \nformat\tascii  1.0\nelement  vertex 2 \nproperty\tfloat x\nproperty float  y\n"
           "property float z\t\nend_header \n\n +1\t2\n\n3 -4e0\n.5 6.",
           expect_table(positions({{1, 2, 3}, {-4, 0.5, 6}})));
  for (const PlyFormat format : kFormats) {
    std::string garbage = "\ntrailing \xff garbage";
    garbage += '\0';
    for (int i = 0; i < 5000; ++i) garbage += static_cast<char>((i * 37) % 256);
    list.add("trailing garbage", fmt::format("trailing_{}.ply", name_of(format)),
             "Five thousand bytes of nonsense behind the last vertex",
             ply_text(table, format) + garbage, expect);
  }
  // The reader must not mistake the first byte of the data for part of the last line end of the
  // header.
  const PlyTable breaks = positions({{10, 13, 10}, {13, 10, 32}, {9, 0, 10}}, PlyType::uint8);
  list.add("CRLF", "data_like_line_ends.ply",
           "Binary data that begin with the bytes of line ends, behind a header of LF",
           ply_text(breaks, PlyFormat::little_endian), expect_table(breaks));
  list.add("CRLF", "data_like_line_ends_crlf.ply", "The same behind a header of CR LF",
           ply_text(breaks, PlyFormat::little_endian, "\r\n"), expect_table(breaks));
  list.add("CRLF", "cr_only.ply", "Lines that end in CR alone, as on old Macs",
           ply_text(three(), PlyFormat::ascii, "\r"), expect_table(three()));
}

void add_sizes(CaseList& list) {
  constexpr const char* kRow = "header larger than the data";
  const PlyTable table = ball(3);
  const std::array<std::pair<const char*, const char*>, 2> counts{
      {{"2e9", "2000000000"}, {"2e64", "18446744073709551615"}}};
  for (const PlyFormat format : kFormats) {
    for (const auto& [name, count] : counts) {
      const std::string header = ply_begin(format) + ply_declaration(table, count) + "end_header\n";
      const std::string text = header + ply_rows(table, format);
      const std::string place =
          format == PlyFormat::ascii ? "line 17" : fmt::format("byte {}", text.size());
      list.add(kRow, fmt::format("count_{}_{}.ply", name, name_of(format)),
               fmt::format("{} vertices declared, three there", count), text,
               expect_error({place, "property x", fmt::format("vertex 3 of {}", count)}));
    }
  }
  const auto add_count = [&](const char* file, const char* count) {
    list.add(kRow, file, fmt::format("The count {}", count),
             ply_begin(PlyFormat::ascii) + ply_declaration(three(), count) + "end_header\n" +
                 ply_rows(three(), PlyFormat::ascii),
             expect_error({"line 3", "vertex", count}));
  };
  add_count("count_beyond_64_bits.ply", "18446744073709551616");
  add_count("count_negative.ply", "-1");
  add_count("count_fraction.ply", "3.5");
  add_count("count_word.ply", "many");

  constexpr const char* kCut = "truncated";
  const PlyTable whole = ball(kBallPoints);
  const std::string binary = ply_text(whole, PlyFormat::little_endian);
  list.add(kCut, "truncated_binary.ply", "Binary data that end within the normal of point 1999",
           binary.substr(0, binary.size() - 10),
           expect_error(
               {fmt::format("byte {}", binary.size() - 10), "property ny", "vertex 1999 of 2000"}));
  const std::string ascii = ply_text(three(), PlyFormat::ascii);
  list.add(kCut, "truncated_ascii.ply", "Ascii data that end before the last number",
           ascii.substr(0, ascii.size() - 3), expect_error({"line 10", "property z", "vertex 2"}));
  list.add(kCut, "truncated_header.ply", "A file that ends within its header",
           binary.substr(0, binary.find("property float nz")),
           expect_error({"line", "end_header"}));
  const std::string mesh = with_lists(PlyFormat::little_endian, ball(10));
  HardExpectation vertices = expect_table(ball(10));
  vertices.cut_at = "property vertex1 of edge 1";
  list.add(kCut, "truncated_edges.ply", "All vertices are there, but the edges behind them are not",
           mesh.substr(0, mesh.size() - 5), vertices);
  list.add(kCut, "empty_file.ply", "No byte at all", "", expect_error({"empty"}));
  list.add(kCut, "magic_only.ply", "The three letters and nothing else", "ply",
           expect_error({"line", "end_header"}));
}

void add_faults(CaseList& list) {
  constexpr const char* kRow = "wrong header";
  const std::string x = "property float x\n", y = "property float y\n", z = "property float z\n";
  const std::string vertex = "element vertex 3\n";
  const auto add = [&](const char* file, const char* title, const std::string& header,
                       std::vector<std::string> names) {
    list.add(kRow, file, title, ascii_with(header), expect_error(std::move(names)));
  };
  add("unknown_type.ply", "A property of type half", vertex + x + "property half y\n" + z,
      {"line 5", "property y", "half"});
  add("unknown_list_type.ply", "A list of type quad",
      vertex + x + y + z + "property list uchar quad w\n", {"line 7", "property w", "quad"});
  add("no_z.ply", "Vertices without z", vertex + x + y, {"line 3", "vertex", "property z"});
  add("property_twice.ply", "x twice", vertex + x + y + x + z, {"line 6", "property x", "twice"});
  add("element_twice.ply", "Element vertex twice", vertex + x + y + z + vertex + x + y + z,
      {"line 7", "vertex", "twice"});
  add("property_first.ply", "A property before the first element", x + vertex + y + z,
      {"line 3", "property"});
  add("property_without_name.ply", "A property that lacks its name",
      vertex + x + "property float\n", {"line 5", "property", "vertex"});
  add("no_properties.ply", "Vertices without any property", vertex, {"line 3", "vertex", "x"});
  add("other_elements_only.ply", "Points under another name", "element point 3\n" + x + y + z,
      {"vertex"});
  const std::string rows = ply_rows(three(), PlyFormat::ascii);
  const std::string rest = ply_declaration(three()) + "end_header\n" + rows;
  list.add(kRow, "unknown_format.ply", "A format that is not there",
           "ply\nformat binary_middle_endian 1.0\n" + rest,
           expect_error({"line 2", "binary_middle_endian"}));
  list.add(kRow, "no_format.ply", "A header without a format", "ply\n" + rest,
           expect_error({"line 6", "format"}));
  list.add(kRow, "not_a_ply.ply", "A file of another kind by the name of .ply",
           "solid cube\n facet normal 0 0 1\n", expect_error({"PLY"}));
  const std::string header =
      ply_begin(PlyFormat::ascii) + ply_declaration(three()) + "end_header\n";
  list.add("wrong data", "word_for_number.ply", "A word where a number should stand",
           header + "0 0 0\n1 zero 0\n0 1 2\n",
           expect_error({"line 9", "property y", "vertex 1", "zero"}));
  list.add("wrong data", "decimal_comma.ply", "Numbers with a decimal comma",
           header + "0,5 0 0\n1 0 0\n0 1 2\n",
           expect_error({"line 8", "property x", "vertex 0", "0,5"}));
  list.add("wrong data", "windows_nan.ply", "A NaN as old Windows libraries print it",
           header + "0 0 0\n1 0 -1.#IND\n0 1 2\n",
           expect_error({"line 9", "property z", "vertex 1", "-1.#IND"}));
  list.add("wrong data", "control_characters.ply",
           "A word that would turn a terminal red, which the message must not repeat",
           header + "0 0 \x1b[31mred\n1 0 0\n0 1 2\n",
           expect_error({"line 8", "property z", "vertex 0", "?[31mred"}));
}

}  // namespace

void add_syntax_cases(std::vector<HardCase>& cases) {
  CaseList list(cases, "ingest");
  add_formats(list);
  add_lists(list);
  add_text(list);
  add_sizes(list);
  add_faults(list);
}

}  // namespace pointreel
