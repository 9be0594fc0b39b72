#include "client/bindings/python/arrays.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "client/bindings/frames/point_arrays.h"
#include "client/bindings/python/call.h"

namespace py = pybind11;

namespace pointreel {
namespace {

/// A view of vectors that `owner` keeps.
template <class Number, class Vector>
py::object view_of(const std::vector<Vector>& vectors, const py::object& owner) {
  static_assert(sizeof(Vector) == 3 * sizeof(Number));
  if (vectors.empty()) return py::array_t<Number>(std::vector<py::ssize_t>{0, 3});
  py::array_t<Number> array(std::vector<py::ssize_t>{static_cast<py::ssize_t>(vectors.size()), 3},
                            std::vector<py::ssize_t>{sizeof(Vector), sizeof(Number)}, &vectors[0].x,
                            owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

const PointCloud& points_of(const py::object& frame) {
  return frame.cast<const PyFrame&>().frame->cloud;
}

/// The numbers of an array; null if they are of another kind.
template <class Number>
const Number* numbers_of(const py::array& array, std::size_t points, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != 3 ||
      static_cast<std::size_t>(array.shape(0)) != points ||
      (array.flags() & py::array::c_style) == 0)
    raise({std::string(name) + " are not an array of one row of three for each point",
           ErrorCode::argument});
  return py::isinstance<py::array_t<Number>>(array) ? static_cast<const Number*>(array.data())
                                                    : nullptr;
}

}  // namespace

py::object positions_of(const py::object& frame) {
  return view_of<float>(points_of(frame).positions, frame);
}

py::object colors_of(const py::object& frame) {
  const PointCloud& cloud = points_of(frame);
  if (!cloud.has_colors()) return py::none();
  return view_of<std::uint16_t>(cloud.colors, frame);
}

py::object normals_of(const py::object& frame) {
  const PointCloud& cloud = points_of(frame);
  if (!cloud.has_normals()) return py::none();
  return view_of<float>(cloud.normals, frame);
}

py::dict scalars_of(const py::object& frame) {
  py::dict scalars;
  for (const ScalarField& field : points_of(frame).scalars) {
    py::array_t<float> array(static_cast<py::ssize_t>(field.values.size()), field.values.data(),
                             frame);
    array.attr("setflags")(py::arg("write") = false);
    scalars[py::str(field.name)] = array;
  }
  return scalars;
}

py::object colors8_of(const PyFrame& frame) {
  const std::vector<glm::u16vec3>& colors = frame.frame->cloud.colors;
  if (colors.empty()) return py::none();
  py::array_t<std::uint8_t> array({static_cast<py::ssize_t>(colors.size()), py::ssize_t{3}});
  {
    std::uint8_t* to = array.mutable_data();
    const ReleasedGil released;
    for (const glm::u16vec3& color : colors)
      for (int axis = 0; axis < 3; ++axis) *to++ = to_8_bits(color)[axis];
  }
  return array;
}

py::array world_of(const PyFrame& frame) {
  const PointCloud& cloud = frame.frame->cloud;
  py::array_t<double> array({static_cast<py::ssize_t>(cloud.size()), py::ssize_t{3}});
  {
    double* to = array.mutable_data();
    const ReleasedGil released;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const glm::dvec3 at = cloud.world(i);
      for (int axis = 0; axis < 3; ++axis) *to++ = at[axis];
    }
  }
  return array;
}

py::array vector_of(const glm::dvec3& vector) { return py::array_t<double>(3, &vector.x); }

py::object box_of(const Box& box) {
  if (box.empty()) return py::none();
  py::array_t<double> array({2, 3});
  for (int axis = 0; axis < 3; ++axis) {
    array.mutable_at(0, axis) = box.min[axis];
    array.mutable_at(1, axis) = box.max[axis];
  }
  return array;
}

PointCloud cloud_of(const py::array& positions, const std::optional<py::array>& colors,
                    const std::optional<py::array>& normals, const glm::dvec3& origin,
                    const py::dict& scalars) {
  PointArrays arrays;
  arrays.count = positions.ndim() > 0 ? static_cast<std::size_t>(positions.shape(0)) : 0;
  arrays.origin = origin;
  arrays.positions = numbers_of<float>(positions, arrays.count, "positions");
  arrays.world_positions = numbers_of<double>(positions, arrays.count, "positions");
  if (arrays.positions == nullptr && arrays.world_positions == nullptr)
    raise({"positions are neither float32 nor float64", ErrorCode::argument});
  if (colors) {
    arrays.colors_8 = numbers_of<std::uint8_t>(*colors, arrays.count, "colors");
    arrays.colors_16 = numbers_of<std::uint16_t>(*colors, arrays.count, "colors");
    if (arrays.colors_8 == nullptr && arrays.colors_16 == nullptr)
      raise({"colors are neither uint8 nor uint16", ErrorCode::argument});
  }
  if (normals) {
    arrays.normals = numbers_of<float>(*normals, arrays.count, "normals");
    if (arrays.normals == nullptr) raise({"normals are not float32", ErrorCode::argument});
  }
  for (const auto& [name, values] : scalars) {
    const auto array = py::cast<py::array>(values);
    if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != arrays.count ||
        !py::isinstance<py::array_t<float>>(array) || (array.flags() & py::array::c_style) == 0)
      raise({"a scalar field is not an array of one float32 for each point", ErrorCode::argument});
    arrays.scalars.push_back(
        {py::cast<std::string>(name), static_cast<const float*>(array.data())});
  }
  return without_gil([&] { return cloud_of(arrays); });
}

}  // namespace pointreel
