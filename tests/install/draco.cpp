// The same with Draco, through the functions that read and write either codec.
#include <cstdio>

#include <pointreel/draco.h>

int main() {
  pointreel::PointCloud cloud;
  for (int i = 0; i < 1000; ++i)
    cloud.positions.emplace_back(i % 10 + 0.5f, i / 10 % 10 + 0.5f, i / 100 + 0.5f);
  const pointreel::EncodeOptions options{pointreel::DracoOptions{}};
  const auto frame = pointreel::encode_frame(cloud, {glm::dvec3(0.0), 16.0}, options);
  if (!frame) return std::printf("cannot encode: %s\n", frame.error().message.c_str());
  const auto decoded = pointreel::decode_frame(pointreel::layer_views(frame->layers));
  if (!decoded) return std::printf("cannot decode: %s\n", decoded.error().message.c_str());
  std::printf("%zu of %zu points in %zu bytes\n", decoded->cloud.size(), cloud.size(),
              frame->size());
  return decoded->cloud.size() == cloud.size() ? 0 : 1;
}
