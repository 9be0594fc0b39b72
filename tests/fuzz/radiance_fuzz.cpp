//   radiance_fuzz -max_len=65536 CORPUS_COPY tests/fuzz/corpus/radiance

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "client/scene/radiance_picture.h"

/// Any bytes give a small picture of finite light that is not negative, or an error of one line.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pointreel;
  const auto map = parse_radiance({data, size});
  if (!map) {
    const std::string& message = map.error().message;
    if (message.empty() || message.find('\n') != std::string::npos) std::abort();
    return 0;
  }
  if (map->height < 1 || map->height > kMostEnvironmentRows || map->width < 1) std::abort();
  if (map->texels.size() !=
      static_cast<std::size_t>(map->width) * static_cast<std::size_t>(map->height))
    std::abort();
  for (const glm::vec3& light : map->texels)
    for (int i = 0; i < 3; ++i)
      if (!std::isfinite(light[i]) || light[i] < 0.0f) std::abort();
  return 0;
}
