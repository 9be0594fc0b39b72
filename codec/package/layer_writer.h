#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/running_checksum.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// Writes one layer file of a segment, frame after frame, and collects its entry in the manifest.
/// The file's name ends in the first half of its checksum, NAME.01234567.prs: caches keep layer
/// files for good, so files with other bytes, for instance of a reel that is packed again, must
/// have other names.
class LayerWriter {
 public:
  LayerWriter(const std::filesystem::path& folder, const std::string& name);

  /// The chunks are empty if the frame does not have this layer.
  void append(const Chunks<Bytes>& layer);

  /// The finished entry; an error if anything could not be written.
  Result<LayerFile> finish();

 private:
  void write(const Bytes& bytes);
  void note_error();

  std::filesystem::path folder_;
  std::ofstream out_;
  RunningChecksum checksum_;
  LayerFile file_;
  int error_ = 0;  ///< errno of the first failure
};

}  // namespace pointreel
