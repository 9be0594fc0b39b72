#include <utility>

#include "client/render/light_probe.h"
#include "client/render/shading.h"
#include "client/scene/radiance_picture.h"
#include "client/web/wasm/camera.h"
#include "client/web/wasm/errors.h"
#include "client/web/wasm/region.h"

using namespace pointreel;

static_assert(PR_FLAT == static_cast<int>(Light::flat) &&
              PR_STUDIO == static_cast<int>(Light::studio) &&
              PR_ENVIRONMENT == static_cast<int>(Light::environment));
static_assert(sizeof(ShadingView) == 88 * sizeof(float));
static_assert(LightProbe::kGlossyEdge == 32);

struct PrEnvironment {
  EnvironmentMap map;
};

struct PrProbe {
  LightProbe probe;
};

PrEnvironment* pr_environment_new(const std::uint8_t* bytes, std::uint32_t size) {
  auto map = parse_radiance({bytes, size});
  if (map) return new PrEnvironment{*std::move(map)};
  report(map.error());
  return nullptr;
}

void pr_environment_free(PrEnvironment* environment) { delete environment; }

PrProbe* pr_probe_new(const PrEnvironment* environment, double roughness) {
  return new PrProbe{
      make_light_probe(environment != nullptr ? environment->map : studio_environment(),
                       static_cast<float>(roughness))};
}

void pr_probe_free(PrProbe* probe) { delete probe; }

const float* pr_probe_glossy(const PrProbe* probe) { return &probe->probe.glossy.front().x; }

const float* pr_shading(const PrCamera* camera, const PrBounds* bounds, double origin_x,
                        double origin_y, double origin_z, PrColor color, PrLight light,
                        std::int32_t lighting, double roughness, const PrProbe* probe) {
  static ShadingView shading;
  DrawOptions options;
  options.color = static_cast<ColorSource>(color);
  options.light = static_cast<Light>(light);
  options.lighting = lighting != 0;
  options.roughness = static_cast<float>(roughness);
  shading = make_shading(options, probe != nullptr ? probe->probe : LightProbe{},
                         camera_of(*camera), bounds_of(*bounds), {origin_x, origin_y, origin_z});
  return &shading.to_environment[0][0];
}
