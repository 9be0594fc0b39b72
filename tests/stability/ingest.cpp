#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include <fmt/format.h>

#include "codec/core/build.h"
#include "codec/files/cloud_file.h"
#include "datasets_synthetic/hard_cases.h"
#include "pointreel/octree.h"
#include "tests/stability/check.h"

namespace pointreel::stability {
namespace {

/// The outcomes of the files of one kind.
struct Tally {
  std::size_t read = 0, refused = 0, points = 0, dropped = 0;
  std::string wrong;  ///< the first file with a wrong outcome, and the reason
};

/// The difference between the cloud and the expectation; empty if there is none.
std::string fault(const HardExpectation& expect, const PointCloud& cloud) {
  if (cloud.size() != expect.points) return fmt::format("{} points", cloud.size());
  const bool some = !cloud.empty();
  if (some && (cloud.has_normals() != expect.normals || cloud.has_colors() != expect.colors ||
               cloud.has_radii() != expect.radii)) {
    return "other attributes";
  }
  const auto unknown = std::count(cloud.normals.begin(), cloud.normals.end(), glm::vec3(0.0f));
  if (unknown > 0) return fmt::format("{} unknown normals", unknown);
  const Box box = bounds(cloud);
  if (box.empty() != expect.bounds.empty()) return "other bounds";
  if (!box.empty()) {
    const glm::dvec3 off =
        glm::max(glm::abs(box.min - expect.bounds.min), glm::abs(box.max - expect.bounds.max));
    if (!(std::max({off.x, off.y, off.z}) <= expect.tolerance)) return "other bounds";
  }
  if (expect.first_color && cloud.colors.front() != *expect.first_color) return "another colour";
  const auto tree = sort_to_depth(cloud, bounding_cube(box), DepthRule::by_delta(0.0));
  if (!tree) return tree.error().message;
  const Svo svo = build_svo(tree->sorted, tree->depth);
  if (svo.depth != expect.depth.value_or(svo.depth) ||
      svo.leaf_count() != expect.leaves.value_or(svo.leaf_count())) {
    return fmt::format("a tree of depth {} with {} leaves", svo.depth, svo.leaf_count());
  }
  return "";
}

std::string fault(const HardExpectation& expect, const Error& error) {
  for (const std::string& name : expect.error_names) {
    if (error.message.find(name) == std::string::npos) return "an error without " + name;
  }
  return error.message.find('\n') == std::string::npos ? "" : "an error of several lines";
}

void read(const HardCase& hard, Tally& tally) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(hard.bytes.data());
  const auto loaded = read_cloud(ByteView(data, hard.bytes.size()));
  std::string wrong;
  if (loaded.has_value() != hard.expect.reads()) {
    wrong = loaded ? "read where it must not" : loaded.error().message;
  } else {
    wrong = loaded ? fault(hard.expect, loaded->cloud) : fault(hard.expect, loaded.error());
  }
  loaded ? ++tally.read : ++tally.refused;
  if (loaded) tally.points += loaded->cloud.size();
  tally.dropped += hard.expect.dropped;
  if (!wrong.empty() && tally.wrong.empty()) tally.wrong = hard.file + ": " + wrong;
}

std::string required(const std::string& subject, const Tally& tally) {
  static const std::map<std::string, std::string> special = {
      {"NaN or infinite position", "dropped and counted, in no bounding box"},
      {"far coordinates", "origin subtracted in double; bounds as written"},
      {"unusable normal", "estimated; all have length 1"},
      {"unusable radius", "estimated from neighbours; capped at a percentile"},
      {"header larger than the data", "one line that names the place; no memory allocated"},
      {"maximum face", "clamps to the last cell: depth and leaves as counted by hand"},
      {"no extent", "still a valid cube: depth and leaves as counted by hand"},
      {"no points", "an empty cloud and an empty tree"},
      {"identical points", "one cell"},
      {"level 21", "depth and leaves as counted by hand"},
      {"input order", "the same tree in either order"}};
  const auto found = special.find(subject);
  if (found != special.end()) return found->second;
  if (tally.refused == 0) return "reads what was written";
  return tally.read == 0 ? "one line that names the place"
                         : "reads, or one line that names the place";
}

}  // namespace

Checks ingest_checks() {
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, Tally> tallies;
  for (const HardCase& hard : hard_cases()) {
    const auto [place, added] = tallies.try_emplace({hard.stage, hard.row});
    if (added) order.push_back(place->first);
    read(hard, place->second);
  }
  Checks checks;
  for (const auto& key : order) {
    const Tally& tally = tallies[key];
    std::string outcome;
    if (tally.read > 0)
      outcome = fmt::format("{} {} read, {} points", tally.read, tally.read == 1 ? "file" : "files",
                            tally.points);
    if (tally.dropped > 0) outcome += fmt::format(", {} dropped", tally.dropped);
    if (tally.refused > 0) {
      outcome += fmt::format("{}{} refused", outcome.empty() ? "" : "; ", tally.refused);
    }
    if (!tally.wrong.empty()) outcome = tally.wrong;
    checks.push_back(
        {key.first, key.second, required(key.second, tally), outcome, tally.wrong.empty()});
  }
  return checks;
}

}  // namespace pointreel::stability
