// Reading any bytes as sweeps of a laser scanner, and guessing their floats, gives a cloud or an
// error, and no more points than bytes.
#include "codec/files/sweep.h"
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(sweep) {
  require(read_points(input, CloudFormat::sweep) <= input.size());
  require(read_points(input, CloudFormat::nuscenes_sweep) <= input.size());
  // As two files of one sequence.
  const std::vector<ByteView> files{input.first(input.size() / 2), input.subspan(input.size() / 2)};
  const std::vector<std::uint64_t> sizes{files[0].size(), files[1].size()};
  const std::vector<std::string> columns = guess_sweep_columns(sizes, files);
  require(columns.empty() || (columns.size() >= 3 && columns.size() <= 8));
  for (const ByteView file : files)
    require(read_points(file, CloudFormat::sweep, {columns, 255.0}) <= input.size());
}
