#pragma once

#include <optional>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "client/bindings/frames/point_frame.h"
#include "pointreel/cloud.h"
#include "pointreel/geometry.h"

/// Points and arrays of numpy.
namespace pointreel {

/// What Python has of a frame: it is shared, so that arrays keep it.
struct PyFrame {
  SharedFrame frame;
};

// The frame's own numbers, without a copy and read-only; each array keeps the frame. None if the
// frame does not have the attribute.

pybind11::object positions_of(const pybind11::object& frame);  ///< float32, n x 3
pybind11::object colors_of(const pybind11::object& frame);     ///< uint16, n x 3
pybind11::object normals_of(const pybind11::object& frame);    ///< float32, n x 3

/// A dict of name to float32, n: the frame's own numbers as above.
pybind11::dict scalars_of(const pybind11::object& frame);

/// uint8, n x 3, a copy; None if the frame has no colours.
pybind11::object colors8_of(const PyFrame& frame);
/// float64, n x 3: origin + position, a copy.
pybind11::array world_of(const PyFrame& frame);
/// float64, 3.
pybind11::array vector_of(const glm::dvec3& vector);
/// float64, 2 x 3: the smallest and the largest coordinates; None for an empty box.
pybind11::object box_of(const Box& box);

/// The points of arrays that lie in memory without gaps: positions of float32 or float64, colours
/// of uint8 or uint16, normals of float32, each n x 3; and scalar fields by name, of float32, n.
/// pointreel/__init__.py makes them so. Raises
/// pointreel.Error where they are not.
PointCloud cloud_of(const pybind11::array& positions, const std::optional<pybind11::array>& colors,
                    const std::optional<pybind11::array>& normals, const glm::dvec3& origin,
                    const pybind11::dict& scalars);

}  // namespace pointreel
