#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include <xxhash.h>

#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// Writes one layer file of a segment, frame after frame, and keeps its entry of the manifest. Its
/// name ends in the first half of its checksum, NAME.01234567.prs: caches keep layer files for
/// good, so other bytes, as of a reel packed anew, must have another name.
class LayerWriter {
 public:
  LayerWriter(const std::filesystem::path& folder, const std::string& name);

  /// `layer` is empty where the frame does not have this layer.
  void append(const Chunks<Bytes>& layer);

  /// The finished entry; an error if anything could not be written.
  Result<LayerFile> finish();

 private:
  void write(const Bytes& bytes);

  struct FreeState {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::filesystem::path folder_;
  std::ofstream out_;
  std::unique_ptr<XXH3_state_t, FreeState> hash_;
  LayerFile file_;
};

}  // namespace pointreel
