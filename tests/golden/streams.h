#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Frames whose bytes are kept in the repository, with what they decode to or the error that they
/// must give: README.md.
namespace pointreel::golden {

struct Stream {
  std::string name;
  EncodedFrame frame;
};

/// What today's encoders make of small clouds with every feature of the format.
Result<std::vector<Stream>> good_streams();

/// Good streams, each changed in one way: "bad_..." are damaged or forged, "odd_..." are good, but
/// not what the encoders make.
Result<std::vector<Stream>> changed_streams();

/// Of each prefix of the layers: the depth, the number of points, and hashes of cells, colours and
/// normals; of a frame that does not decode the error.
nlohmann::json outcome(const EncodedFrame& frame);

/// A file of a frame: the number of layers, then of each layer geometry, colours and normals, each
/// behind its size; numbers are u32, little endian.
Bytes file_of(const EncodedFrame& frame);
Result<EncodedFrame> frame_of(ByteView file);

/// Writes all streams and `outcomes.json` to the folder.
Result<void> write_streams(const std::filesystem::path& folder);

}  // namespace pointreel::golden
