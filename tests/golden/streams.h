#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Frames that are kept in the repository, each with what it must decode to, or with the code of
/// the error that it must give: README.md.
namespace pointreel::golden {

struct Stream {
  std::string name;
  EncodedFrame frame;
};

/// Makes frames of small clouds with today's encoders, using every feature of the format.
Result<std::vector<Stream>> good_streams();

/// Good streams, each with one change: "bad_..." are damaged or forged; "odd_..." are valid, but no
/// encoder makes them.
Result<std::vector<Stream>> changed_streams();

/// For each prefix of the layers, the depth, the number of points, and hashes of cells, colours and
/// normals; for a frame that does not decode, the error's code.
nlohmann::json outcome(const EncodedFrame& frame);

/// The file of a frame: the number of layers, and for each layer its geometry, colours and normals,
/// each after its size. Numbers are u32, little endian.
Bytes file_of(const EncodedFrame& frame);
Result<EncodedFrame> frame_of(ByteView file);

/// Writes all streams and `outcomes.json` to the folder.
Result<void> write_streams(const std::filesystem::path& folder);

}  // namespace pointreel::golden
