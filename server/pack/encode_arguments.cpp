#include "server/pack/encode_arguments.h"

#include <cmath>

#include <fmt/format.h>

#include "codec/octree/slabs.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace {

/// The first of the options that was given, if any.
const CLI::Option* given(const std::vector<CLI::Option*>& options) {
  for (const CLI::Option* option : options) {
    if (option->count() > 0) return option;
  }
  return nullptr;
}

void add_octree_options(CLI::App& command, EncodeArguments& a) {
  const char* group = "Octree";
  a.octree_only.push_back(command.add_option("--entropy", a.entropy, "entropy stage")
                              ->check(CLI::IsMember({"none", "zstd", "context"}))
                              ->capture_default_str()
                              ->group(group));
  a.slabs_option = command
                       .add_option("--slabs", a.slabs,
                                   "parts of a frame that go to different threads of encoder and "
                                   "player, at about one percent of a frame's bytes each; 0: one "
                                   "below 2^20 voxels, then one for each 2^19")
                       ->check(CLI::Range(0, kMostSlabs))
                       ->capture_default_str()
                       ->group(group);
  a.octree_only.push_back(a.slabs_option);
  a.delta_option = command.add_option("--delta", a.delta,
                                      "depth by the share of points that may merge into others");
  a.depth_option =
      command.add_option("--depth", a.depth, "a fixed depth, 0 to 21")->check(CLI::Range(0, 21));
  a.voxel_option = command.add_option(
      "--voxel", a.voxel_size, "a fixed voxel edge in the source's units, voxels on its multiples");
  a.delta_option->capture_default_str()
      ->group(group)
      ->excludes(a.depth_option)
      ->excludes(a.voxel_option);
  a.depth_option->group(group)->excludes(a.voxel_option);
  a.voxel_option->group(group);
  a.octree_only.push_back(
      command
          .add_option("--quality", a.quality,
                      "of colours, 1 to 100: 14 more halve their error, 100 is lossless")
          ->check(CLI::Range(1, kLosslessColorQuality))
          ->capture_default_str()
          ->group(group));
  a.octree_only.push_back(
      command
          .add_option("--normal-quality", a.normal_quality,
                      "of normals, 1 to 100, on the same scale; 100 is half a degree")
          ->check(CLI::Range(1, kBestNormalQuality))
          ->capture_default_str()
          ->group(group));
  for (CLI::Option* option : {a.delta_option, a.depth_option, a.voxel_option}) {
    a.octree_only.push_back(option);
  }
}

void add_draco_options(CLI::App& command, EncodeArguments& a) {
  const auto add = [&](const char* flag, int& value, const char* what, int min, int max) {
    a.draco_only.push_back(command.add_option(flag, value, what)
                               ->check(CLI::Range(min, max))
                               ->capture_default_str()
                               ->group("Draco"));
  };
  add("--qp", a.draco.position_bits, "bits of a position", 1, 21);
  add("--qn", a.draco.normal_bits, "bits of a normal", 2, 16);
  add("--qg", a.draco.generic_bits, "bits of a generic attribute", 1, 30);
  add("--cl", a.draco.compression_level, "compression level, 10 smallest", 0, 10);
  a.draco_only.push_back(
      command.add_option("--method", a.method, "auto: sequential at --cl 0, else kd-tree")
          ->check(CLI::IsMember({"auto", "kd-tree", "sequential"}))
          ->capture_default_str()
          ->group("Draco"));
}

}  // namespace

void EncodeArguments::add_to(CLI::App& command) {
  command.add_option("--codec", codec, "codec")
      ->check(CLI::IsMember({"octree", "draco"}))
      ->capture_default_str();
  CLI::Option* normals_option =
      command
          .add_option("--normals", normals,
                      "send those of the source, or let the client derive them from the points")
          ->check(CLI::IsMember({"send", "derive"}))
          ->capture_default_str();
  command.add_flag("--no-normals", no_normals, "leave normals out, as --normals derive")
      ->excludes(normals_option);
  command.add_flag("--no-colors", no_colors, "leave colours out");
  add_octree_options(command, *this);
  add_draco_options(command, *this);
}

void SequenceArguments::add_to(CLI::App& command, const std::string& name_help) {
  command.add_option("--fps", fps, "frames a second")->capture_default_str();
  command.add_option("--up", up, "the axis that points up")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  command.add_option("--name", name, name_help);
  command.add_option("--threads", threads, "0 for all processors")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

Result<void> SequenceArguments::check() const {
  if (!(fps > 0.0 && fps <= 1e6)) return fail("--fps must be above 0 and at most 1000000");
  return {};
}

Result<EncodeOptions> EncodeArguments::options() const {
  if (!(delta >= 0.0)) return fail("--delta must be 0 or more");
  if (slabs_option->count() > 0 && entropy != "context") {
    return fail("--slabs belongs to --entropy context");
  }
  EncodeOptions options;
  options.normals = !no_normals && normals == "send";
  options.colors = !no_colors;
  const bool is_draco = codec == "draco";
  if (const CLI::Option* wrong = given(is_draco ? octree_only : draco_only)) {
    return fail(
        fmt::format("{} belongs to --codec {}", wrong->get_name(), is_draco ? "octree" : "draco"));
  }
  if (is_draco) {
    DracoOptions draco_options = draco;
    draco_options.method = method == "auto"         ? DracoMethod::automatic
                           : method == "sequential" ? DracoMethod::sequential
                                                    : DracoMethod::kd_tree;
    options.codec = draco_options;
    return options;
  }
  OctreeOptions octree;
  octree.entropy = entropy == "none"   ? Entropy::none
                   : entropy == "zstd" ? Entropy::zstd
                                       : Entropy::context;
  octree.depth = depth_option->count() > 0 ? DepthRule::fixed(depth) : DepthRule::by_delta(delta);
  octree.color_quality = quality;
  octree.normal_quality = normal_quality;
  octree.slabs = slabs;
  options.codec = octree;
  return options;
}

Result<std::optional<double>> EncodeArguments::voxel() const {
  if (voxel_option->count() == 0) return std::optional<double>();
  if (!(voxel_size > 0.0 && std::isfinite(voxel_size))) return fail("--voxel must be above 0");
  return std::optional<double>(voxel_size);
}

}  // namespace pointreel
