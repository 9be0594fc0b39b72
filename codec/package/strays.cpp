#include "codec/package/strays.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/base/spread.h"

namespace pointreel {
namespace {

constexpr std::size_t kSamples = 1024, kFewest = 8;
constexpr double kFar = 100.0;

/// What a few far points do not change.
struct Middle {
  glm::vec3 at{0.0f};   ///< the median on each axis, relative to the origin
  double length = 0.0;  ///< of the middle half, on its longest axis
};

Middle middle_of(const PointCloud& cloud) {
  Middle middle;
  const std::size_t count = std::min(kSamples, cloud.size());
  std::vector<float> values(count);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < count; ++i)
      values[i] = cloud.positions[spread_index(i, count, cloud.size())][axis];
    std::sort(values.begin(), values.end());
    middle.at[axis] = values[count / 2];
    const double low = values[count / 4], high = values[count * 3 / 4];
    middle.length = std::max(middle.length, high - low);
  }
  return middle;
}

double distance_to(const Middle& middle, const glm::vec3& p) {
  const glm::dvec3 away = glm::abs(glm::dvec3(p) - glm::dvec3(middle.at));
  return std::max({away.x, away.y, away.z});
}

std::string place_text(const PointCloud& cloud, std::size_t i, bool numbered) {
  const glm::dvec3 p = cloud.world(i);
  return fmt::format("{} at {:.7g} {:.7g} {:.7g}",
                     numbered ? fmt::format("point {}", i) : "the point", p.x, p.y, p.z);
}

}  // namespace

std::vector<std::size_t> find_strays(const PointCloud& cloud) {
  if (cloud.size() < kFewest) return {};
  const Middle middle = middle_of(cloud);
  const glm::dvec3 extent = bounds(cloud).extent();
  if (!(std::max({extent.x, extent.y, extent.z}) > 0.25 * kFar * middle.length)) return {};
  std::vector<double> distances;
  distances.reserve(cloud.size());
  for (const glm::vec3& p : cloud.positions) distances.push_back(distance_to(middle, p));
  std::vector<double> sorted = distances;
  std::sort(sorted.begin(), sorted.end());
  std::size_t last = sorted.size() - sorted.size() / 4 - 1;
  const auto is_last = [&] { return sorted[last] > 0.0 && sorted[last + 1] > kFar * sorted[last]; };
  while (last + 1 < sorted.size() && !is_last()) ++last;
  std::vector<std::size_t> strays;
  for (std::size_t i = 0; i < distances.size(); ++i)
    if (distances[i] > sorted[last]) strays.push_back(i);
  return strays;
}

std::string strays_text(const PointCloud& cloud, const std::vector<std::size_t>& strays,
                        bool numbered) {
  const std::string first = place_text(cloud, strays.front(), numbered);
  if (strays.size() == 1) return first + " lies far from all others";
  return fmt::format("{} points lie far from all others, such as {}", strays.size(), first);
}

std::string strays_text(const PointCloud& cloud) {
  const std::vector<std::size_t> strays = find_strays(cloud);
  return strays.empty() ? std::string() : strays_text(cloud, strays, false);
}

Error blame(const std::string& strays, Error error) {
  if (strays.empty()) return error;
  return {fmt::format("{}: remove such points ({})", strays, error.message), ErrorCode::limit};
}

std::string farthest_text(const PointCloud& cloud) {
  if (cloud.empty()) return {};
  const Middle middle = middle_of(cloud);
  const auto farthest = std::max_element(cloud.positions.begin(), cloud.positions.end(),
                                         [&](const glm::vec3& a, const glm::vec3& b) {
                                           return distance_to(middle, a) < distance_to(middle, b);
                                         });
  return place_text(cloud, static_cast<std::size_t>(farthest - cloud.positions.begin()), false);
}

}  // namespace pointreel
