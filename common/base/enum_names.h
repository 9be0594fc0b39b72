#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace pointreel {

template <class Enum>
struct EnumName {
  Enum value;
  const char* name;
};

/// The values of an enumeration and their names, in the order in which users are offered them. An
/// enumeration with names specialises it directly after its definition:
///
///   enum class Shape { disc, cube };
///   template <>
///   inline constexpr auto kEnumNames<Shape> =
///       std::to_array<EnumName<Shape>>({{Shape::disc, "disc"}, {Shape::cube, "cube"}});
///
///   for (const auto& [value, name] : kEnumNames<Shape>) ...
template <class Enum>
inline constexpr std::array<EnumName<Enum>, 0> kEnumNames{};

template <class Enum>
concept NamedEnum = std::is_enum_v<Enum> && (kEnumNames<Enum>.size() > 0);

/// Empty for a number that is no value of the enumeration.
template <NamedEnum Enum>
constexpr const char* name(Enum value) {
  for (const EnumName<Enum>& named : kEnumNames<Enum>)
    if (named.value == value) return named.name;
  return "";
}

/// The value of that name, if there is one: parse_enum<Shape>("disc").
template <NamedEnum Enum>
constexpr std::optional<Enum> parse_enum(std::string_view name) {
  for (const EnumName<Enum>& named : kEnumNames<Enum>)
    if (named.name == name) return named.value;
  return std::nullopt;
}

/// The value after this one; the first after the last.
template <NamedEnum Enum>
constexpr Enum next(Enum value) {
  constexpr auto& all = kEnumNames<Enum>;
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    if (all[i].value == value) return all[i + 1].value;
  return all[0].value;
}

/// All names, for messages: "disc, cube".
template <NamedEnum Enum>
std::string list_names() {
  std::string list;
  for (const EnumName<Enum>& named : kEnumNames<Enum>) {
    if (!list.empty()) list += ", ";
    list += named.name;
  }
  return list;
}

}  // namespace pointreel
