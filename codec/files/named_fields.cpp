#include "codec/files/named_fields.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "codec/files/attribute_names.h"
#include "codec/files/ply_header.h"
#include "common/base/concat.h"
#include "common/base/letter_case.h"

namespace pointreel {
namespace {

/// Fields that have not been given a meaning.
class Unassigned {
 public:
  explicit Unassigned(const std::vector<NamedField>& fields) : fields_(fields) {
    taken_.resize(fields.size());
  }

  /// The first of the spellings that is complete.
  std::optional<RecordVector> take(std::span<const VectorNames> spellings) {
    for (const VectorNames& names : spellings) {
      std::array<std::size_t, 3> at{};
      for (std::size_t i = 0; i < 3; ++i) at[i] = find(names[i]);
      if (std::max({at[0], at[1], at[2]}) == fields_.size()) continue;
      RecordVector vector;
      for (std::size_t i = 0; i < 3; ++i) {
        vector[i] = fields_[at[i]].field;
        taken_[at[i]] = true;
      }
      return vector;
    }
    return std::nullopt;
  }

  /// A number of four bytes.
  std::optional<RecordField> take_packed() {
    for (const std::string_view name : kPackedColorNames) {
      const std::size_t at = find(name);
      if (at == fields_.size() || size_of(fields_[at].field.type) != 4) continue;
      taken_[at] = true;
      return fields_[at].field;
    }
    return std::nullopt;
  }

  /// Makes scalar fields of what is left, as far as there may be some.
  std::vector<RecordScalar> scalars(std::vector<std::string>& unread) const {
    const std::vector<bool> chosen = choose_scalars();
    std::vector<RecordScalar> scalars;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const std::string& name = fields_[i].name;
      if (taken_[i] || name == "_") continue;
      if (chosen[i]) {
        scalars.push_back({name, fields_[i].field});
      } else {
        unread.push_back(printable_name(name));
      }
    }
    return scalars;
  }

 private:
  /// Up to kMaxScalars, what is measured before anything else, and none of a name twice.
  std::vector<bool> choose_scalars() const {
    std::vector<bool> chosen(fields_.size(), false);
    std::vector<std::string_view> names;
    for (const bool measured : {true, false}) {
      for (std::size_t i = 0; i < fields_.size() && names.size() < kMaxScalars; ++i) {
        const std::string& name = fields_[i].name;
        const auto is_name = [&](std::string_view other) { return equal_in_any_case(name, other); };
        if (taken_[i] || name == "_" || !is_scalar_name(name)) continue;
        if (std::any_of(kMeasuredNames.begin(), kMeasuredNames.end(), is_name) != measured)
          continue;
        if (std::find(names.begin(), names.end(), name) != names.end()) continue;
        chosen[i] = true;
        names.push_back(name);
      }
    }
    return chosen;
  }

  std::size_t find(std::string_view name) const {
    for (std::size_t i = 0; i < fields_.size(); ++i)
      if (!taken_[i] && equal_in_any_case(fields_[i].name, name)) return i;
    return fields_.size();
  }

  const std::vector<NamedField>& fields_;
  std::vector<bool> taken_;
};

}  // namespace

Result<RecordLayout> layout_of(const std::vector<NamedField>& fields,
                               std::vector<std::string>& unread) {
  Unassigned unassigned(fields);
  RecordLayout layout;
  const auto position = unassigned.take(kPositionNames);
  if (!position) {
    for (const std::string_view name : kPositionNames.front()) {
      const bool there = std::any_of(fields.begin(), fields.end(), [&](const NamedField& field) {
        return equal_in_any_case(field.name, name);
      });
      if (!there) return fail(concat("the points have no field ", name));
    }
  }
  layout.position = *position;
  layout.normal = unassigned.take(kNormalNames);
  layout.color = unassigned.take(kColorNames);
  if (!layout.color) layout.packed_color = unassigned.take_packed();
  layout.scalars = unassigned.scalars(unread);
  return layout;
}

}  // namespace pointreel
