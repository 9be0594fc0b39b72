#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"

namespace pointreel {

/// The options of a command line that say how frames are encoded, as they were given; what they are
/// set to before they are added are their defaults.
struct EncodeArguments {
  std::string codec = "octree", entropy = "context", normals = "send", method = "auto";
  double delta = 0.05, voxel_size = 0.0;
  int depth = 10, quality = kDefaultColorQuality, normal_quality = kDefaultNormalQuality;
  int slabs = 0;
  bool no_normals = false, no_colors = false;
  DracoOptions draco;

  CLI::Option *delta_option = nullptr, *depth_option = nullptr, *voxel_option = nullptr;
  CLI::Option* slabs_option = nullptr;
  /// Those that make no sense with the other codec.
  std::vector<CLI::Option*> octree_only, draco_only;

  /// Adds them to a command, which this outlives.
  void add_to(CLI::App& command);
  /// What they mean, or which of them does not go with which.
  Result<EncodeOptions> options() const;
  /// Of --voxel, which options() has no say in.
  Result<std::optional<double>> voxel() const;
};

/// The options that say what a sequence of frames is, and how many processors encode it; likewise.
struct SequenceArguments {
  std::string name, up = "y";
  double fps = 30.0;
  int threads = 0;

  void add_to(CLI::App& command, const std::string& name_help);
  /// What is wrong with them.
  Result<void> check() const;
};

}  // namespace pointreel
