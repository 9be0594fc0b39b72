#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/segments/pack_options.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Writes a package from clouds in memory, frame after frame, with the bytes that pack writes for
/// the same clouds in files. The package is either complete, once `finish` has returned, or absent.
/// Of the options, those do not matter here that are about files, cleaning, sound, tables and the
/// time or the threads of encoding, nor those that are decided by the whole sequence.
///
/// The frames of a segment are kept until it is complete, because they share a cube. A segment ends
/// early where its points take more than 512 MiB. Its frames are encoded at the same time, by the
/// threads of the calling TBB arena; the bytes do not depend on how many there are.
class PackageWriter {
 public:
  /// Errors: `argument` for options out of range, or if something else than a package is there;
  /// `io`.
  static Result<PackageWriter> create(const PackOptions& options);
  PackageWriter(PackageWriter&&) noexcept;
  PackageWriter& operator=(PackageWriter&&) noexcept;
  ~PackageWriter();

  /// Adds a frame, whose points are made safe to use first (`sanitize`). `time_us`: when it is
  /// shown, from the reel's start, and not before the frame that was added last; by default, frames
  /// are shown at EncodingOptions::fps. `limit` if a segment exceeds the bit rate, or if points lie
  /// so far away that a frame of the segment would collapse (collapse.h). After an error, or once
  /// it was stopped (`cancelled`), nothing more can be written.
  Result<void> add(PointCloud cloud, std::optional<std::uint64_t> time_us = {},
                   const std::stop_token& stop = {});

  /// The Unix time at which the package begins. Without it, the package does not tell.
  void captured(std::uint64_t unix_us);

  /// Writes the rest and puts the package in its place. Errors: `argument` if there are no frames.
  Result<void> finish(const std::stop_token& stop = {});

  /// What there is to warn users of since the last call.
  std::vector<std::string> take_warnings();

 private:
  class Impl;
  explicit PackageWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pointreel
