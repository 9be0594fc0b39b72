#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_options.h"
#include "codec/surface/clean_in_time.h"
#include "pointreel/error.h"

namespace pointreel {

/// A frame as it is encoded: read, and cleaned if that was asked for.
struct SourceFrame : LoadedCloud {
  CleanReport cleaning;
  std::string strays;              ///< names the points that lie far from all others, and the file
  bool unreadable = false;         ///< this is another frame, shown in its place
  bool normals_estimated = false;  ///< the file has none
};

/// A cloud as a frame that is not cleaned yet: placed, and with PackOptions::best_effort without
/// strays. `name`: of the frame, with which errors begin.
Result<SourceFrame> source_frame(LoadedCloud loaded, const std::string& name,
                                 const PackOptions& options);

/// With MissingNormals::estimated, gives octrees the normals that the source lacks.
void add_missing_normals(SourceFrame& source, const PackOptions& options);

/// Reads the frames of a sequence. With PackOptions::best_effort, strays are left out, and with
/// MissingNormals::estimated, octrees get normals. With
/// EncodingOptions::clean_frames, frames are cleaned together with those around them in the
/// sequence, whatever segments or parts they are in; some of them stay in memory for this.
class SourceFrames {
 public:
  /// `sequence` and `options` must outlive this object.
  SourceFrames(std::span<const CloudFrame> sequence, const PackOptions& options);
  ~SourceFrames();

  std::string name(std::size_t frame) const { return sequence_[frame].name(); }

  /// From any thread. The error begins with the file.
  Result<SourceFrame> read(std::size_t frame) const;

 private:
  struct Alone;
  class Recent;

  Result<SourceFrame> load(std::size_t frame) const;
  Result<SourceFrame> read_cleaned(std::size_t frame) const;
  Result<std::shared_ptr<const Alone>> alone(std::size_t frame) const;
  std::vector<std::size_t> around(std::size_t frame) const;

  const std::span<const CloudFrame> sequence_;
  const PackOptions& options_;
  const std::unique_ptr<Recent> recent_;
};

}  // namespace pointreel
