#include "client/web/wasm/camera.h"

#include <cstring>
#include <vector>

#include "client/scene/floor_grid.h"

using namespace pointreel;

namespace {

Box box_of(const double* numbers) {
  return {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
}

template <class Change>
void change(PrCamera& camera, const Change& how) {
  Camera changed = camera_of(camera);
  how(changed);
  write(changed, camera);
}

void copy(const glm::mat4& from, float* to) { std::memcpy(to, &from[0][0], sizeof(from)); }

std::vector<PrFloorLine> lines;
double floor_place[4];

}  // namespace

Up pointreel::up_of(double number) {
  const int axis = number < 0.0 ? static_cast<int>(-number) : static_cast<int>(number);
  return {static_cast<char>('x' + axis - 1), number < 0.0};
}

double pointreel::number_of(Up up) {
  const double axis = up.axis() + 1;
  return up.reversed() ? -axis : axis;
}

Camera pointreel::camera_of(const PrCamera& from) {
  Camera camera;
  camera.target = {from.target[0], from.target[1], from.target[2]};
  camera.distance = from.distance;
  camera.yaw = from.yaw;
  camera.pitch = from.pitch;
  camera.up = up_of(from.up);
  camera.fov_y = from.fov_y;
  camera.scene_radius = from.scene_radius;
  return camera;
}

void pointreel::write(const Camera& from, PrCamera& to) {
  to = {{from.target.x, from.target.y, from.target.z},
        from.distance,
        from.yaw,
        from.pitch,
        from.fov_y,
        from.scene_radius,
        number_of(from.up)};
}

void pr_camera_init(PrCamera* camera, double up) {
  Camera first;
  first.up = up_of(up);
  write(first, *camera);
}

void pr_camera_frame_bounds(PrCamera* camera, const double* box, double aspect) {
  change(*camera, [&](Camera& c) { c.frame_bounds(box_of(box), aspect); });
}

void pr_camera_fit(PrCamera* camera, const double* box, double aspect, double covered) {
  change(*camera, [&](Camera& c) { c.fit(box_of(box), aspect, covered); });
}

void pr_camera_orbit(PrCamera* camera, double yaw_by, double pitch_by) {
  change(*camera, [&](Camera& c) { c.orbit(yaw_by, pitch_by); });
}

void pr_camera_pan(PrCamera* camera, double right_by, double up_by) {
  change(*camera, [&](Camera& c) { c.pan(right_by, up_by); });
}

void pr_camera_zoom(PrCamera* camera, double factor) {
  change(*camera, [&](Camera& c) { c.zoom(factor); });
}

void pr_camera_zoom_at(PrCamera* camera, double factor, double cursor_x, double cursor_y,
                       double aspect) {
  change(*camera, [&](Camera& c) { c.zoom_at(factor, {cursor_x, cursor_y}, aspect); });
}

void pr_camera_center_on(PrCamera* camera, double x, double y, double z) {
  change(*camera, [&](Camera& c) { c.center_on({x, y, z}); });
}

void pr_camera_fly(PrCamera* camera, double x, double y, double z, double yaw_by, double pitch_by) {
  change(*camera, [&](Camera& c) { c.fly({x, y, z}, yaw_by, pitch_by); });
}

const PrMatrices* pr_camera_matrices(const PrCamera* camera, double origin_x, double origin_y,
                                     double origin_z, double aspect) {
  static PrMatrices matrices;
  const Camera c = camera_of(*camera);
  const glm::mat4 view = c.view_from({origin_x, origin_y, origin_z});
  const glm::mat4 projection = c.projection(aspect);
  copy(view, matrices.view);
  copy(projection, matrices.projection);
  copy(projection * view, matrices.to_clip);
  matrices.near_plane = static_cast<float>(c.near_plane());
  return &matrices;
}

const double* pr_camera_axes(const PrCamera* camera) {
  static double numbers[12];
  const Camera c = camera_of(*camera);
  const glm::dvec3 eye = c.eye();
  const glm::dmat3 axes = c.axes();
  std::memcpy(numbers, &eye[0], sizeof(eye));
  std::memcpy(numbers + 3, &axes[0][0], sizeof(axes));
  return numbers;
}

const PrFloorLine* pr_floor_lines(const PrCamera* camera, const double* box) {
  const Camera c = camera_of(*camera);
  const FloorGrid grid{box_of(box), c.up};
  lines.clear();
  for (const FloorLine& line : floor_lines(grid, c)) {
    lines.push_back({{line.from.x, line.from.y, line.from.z},
                     {line.to.x, line.to.y, line.to.z},
                     line.strength,
                     line.step});
  }
  const glm::dvec3 origin = floor_origin(grid);
  std::memcpy(floor_place, &origin[0], sizeof(origin));
  floor_place[3] = floor_reach(grid.bounds);
  return lines.data();
}

std::uint32_t pr_floor_line_count() { return static_cast<std::uint32_t>(lines.size()); }
const double* pr_floor_origin() { return floor_place; }
