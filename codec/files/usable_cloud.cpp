#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/core/keep_points.h"
#include "codec/files/cloud_file.h"
#include "codec/files/ply_header.h"
#include "codec/surface/normals.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"

namespace pointreel {
namespace {

/// "1 point", "2 points".
std::string count(std::size_t n, std::string_view singular) {
  return concat(n, " ", singular, n == 1 ? "" : "s");
}

/// Points at zero are far from the others if their box is so many times its length away.
constexpr double kFarLengths = 16.0;
/// Too few others tell nothing.
constexpr std::size_t kFewestOthers = 16;

/// Whether float or double coordinates relative to an origin stand for zero.
bool is_zero(const PointCloud& cloud, std::size_t i) {
  constexpr double kRounding = 1.0 / (1 << 23);
  const glm::dvec3 p = glm::abs(cloud.world(i));
  const glm::dvec3 close = kRounding * glm::abs(cloud.origin);
  return p.x <= close.x && p.y <= close.y && p.z <= close.z;
}

/// Sensors and programs mark points that they did not measure by 0 0 0. Such points in a cloud on a
/// map's grid would make its box a million times larger.
void leave_out_far_zeros(LoadedCloud& loaded) {
  PointCloud& cloud = loaded.cloud;
  std::size_t first = 0;
  while (first < cloud.size() && !is_zero(cloud, first)) ++first;
  if (first == cloud.size()) return;
  std::size_t zeros = 0;
  Box others;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    is_zero(cloud, i) ? void(++zeros) : others.grow(cloud.world(i));
  if (cloud.size() - zeros < kFewestOthers) return;
  const glm::dvec3 extent = others.extent();
  const glm::dvec3 away = glm::max(glm::max(others.min, -others.max), 0.0);
  const double length = std::max({extent.x, extent.y, extent.z});
  if (!(std::max({away.x, away.y, away.z}) > kFarLengths * length)) return;
  std::string text = concat("left out ", count(zeros, "point"), " at 0 0 0, far from all others");
  if (loaded.left_out == 0) text += concat("; the first is point ", first);
  loaded.warnings.push_back(std::move(text));
  loaded.left_out += keep_points(cloud, [&](std::size_t i) { return !is_zero(cloud, i); });
}

void drop_constant_fields(LoadedCloud& loaded, const Reading& reading) {
  std::erase_if(loaded.cloud.scalars, [&](const ScalarField& field) {
    const auto& omitted = reading.omit_constant;
    const bool omit = omitted ? std::ranges::find(*omitted, field.name) != omitted->end()
                              : field.values.size() > 1 && may_say_nothing(field.name);
    if (!omit || !is_constant(field)) return false;
    loaded.unread.push_back(concat(printable(field.name), " (the same at all points)"));
    return true;
  });
}

/// Normals without a direction are estimated. Where all are, the cloud has none: whoever needs some
/// estimates them for the points that are left by then.
void estimate_unknown_normals(LoadedCloud& loaded, const Executor& executor) {
  std::vector<glm::vec3>& normals = loaded.cloud.normals;
  const auto unknown =
      static_cast<std::size_t>(std::count(normals.begin(), normals.end(), glm::vec3(0.0f)));
  if (unknown == 0) return;
  const bool all = unknown == normals.size();
  loaded.warnings.push_back(
      concat(count(unknown, "point"), unknown == 1 ? " has" : " have",
             " no usable normal: ", all ? "normals are taken to be missing" : "it is estimated"));
  all ? normals.clear() : complete_normals(loaded.cloud, executor);
}

}  // namespace

bool may_say_nothing(std::string_view name) {
  constexpr std::array<std::string_view, 9> kNames{"alpha",
                                                   "a",
                                                   "intensity",
                                                   "reflectance",
                                                   "reflectivity",
                                                   "return number",
                                                   "number of returns",
                                                   "classification",
                                                   "confidence"};
  std::string small = in_small_letters(name);
  if (small.starts_with("scalar_")) small.erase(0, 7);
  const auto letters = [](std::string_view text) {
    std::string only;
    for (const char c : text)
      if (c != ' ' && c != '_') only += c;
    return only;
  };
  return std::any_of(kNames.begin(), kNames.end(),
                     [&](std::string_view known) { return letters(small) == letters(known); });
}

bool is_constant(const ScalarField& field) {
  return std::ranges::all_of(field.values,
                             [&](float value) { return value == field.values.front(); });
}

LoadedCloud usable_cloud(PointCloud cloud, CloudFormat format, ReadNotes notes,
                         const Reading& reading, const Executor& executor) {
  LoadedCloud loaded;
  loaded.cloud = std::move(cloud);
  loaded.warnings = std::move(notes.warnings);
  loaded.unread = std::move(notes.unread);
  const SanitizeReport report = sanitize(loaded.cloud);
  loaded.left_out = report.dropped_positions;
  if (report.dropped_positions > 0 && !has_empty_points(format)) {
    loaded.warnings.push_back(
        concat("dropped ", count(report.dropped_positions, "point"),
               " without a finite position (NaN, infinite, or too large for a float)"));
  }
  leave_out_far_zeros(loaded);
  estimate_unknown_normals(loaded, executor);
  if (report.unknown_radii > 0) {
    loaded.warnings.push_back(
        concat("replaced ", count(report.unknown_radii, "unusable radius value")));
  }
  estimate_unknown_radii(loaded.cloud);
  drop_constant_fields(loaded, reading);
  return loaded;
}

}  // namespace pointreel
