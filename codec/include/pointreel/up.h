#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

namespace pointreel {

/// The direction of the world that points up: along one of its axes, or against it.
class Up {
 public:
  /// Implicit: a letter stands for the axis itself. It is 'x', 'y' or 'z'.
  constexpr Up(char letter, bool reversed = false) : axis_(letter - 'x'), reversed_(reversed) {}

  constexpr int axis() const { return axis_; }  ///< 0, 1 or 2
  constexpr bool reversed() const { return reversed_; }
  constexpr Up opposite() const { return {letter(), !reversed_}; }
  glm::dvec3 direction() const;
  std::string text() const;  ///< as in kUpNames, packages and streams

  constexpr bool operator==(const Up&) const = default;

 private:
  constexpr char letter() const { return static_cast<char>('x' + axis_); }

  int axis_;
  bool reversed_;
};

/// What parse_up accepts, for messages.
inline constexpr const char* kUpNames = "x, -x, y, -y, z, -z";

std::optional<Up> parse_up(std::string_view text);

}  // namespace pointreel
