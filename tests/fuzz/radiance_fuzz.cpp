#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "client/scene/radiance_picture.h"
#include "tests/fuzz/target.h"

/// Any bytes give a small picture of finite light that is not negative, or an error of one line.
FUZZ_TARGET(radiance, .longest = 1 << 16) {
  const auto map = parse_radiance(input);
  if (!map) {
    require(one_line(map.error().message));
    return;
  }
  if (map->height < 1 || map->height > kMostEnvironmentRows || map->width < 1) std::abort();
  if (map->texels.size() !=
      static_cast<std::size_t>(map->width) * static_cast<std::size_t>(map->height))
    std::abort();
  for (const glm::vec3& light : map->texels)
    for (int i = 0; i < 3; ++i)
      if (!std::isfinite(light[i]) || light[i] < 0.0f) std::abort();
}
