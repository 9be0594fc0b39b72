// Reading any bytes as lines of numbers, and guessing their columns, gives a cloud or an error, and
// no more points than bytes.
#include "codec/files/text_points.h"
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(text_points) {
  require(read_points(input, CloudFormat::text) <= input.size());
  // As two files of one sequence.
  const std::vector<ByteView> files{input.first(input.size() / 2), input.subspan(input.size() / 2)};
  for (const bool pts : {false, true}) {
    bool counts = false;
    const std::vector<std::string> columns = guess_text_columns(files, pts, counts);
    for (const ByteView file : files)
      require(read_points(file, CloudFormat::text, {columns, 255.0}) <= input.size());
  }
}
