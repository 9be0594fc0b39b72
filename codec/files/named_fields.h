#pragma once

#include <string>
#include <vector>

#include "codec/files/records.h"
#include "pointreel/error.h"

namespace pointreel {

/// A number of every point, by its name in the file.
struct NamedField {
  std::string name;
  RecordField field;
};

/// Finds out by their names (attribute_names.h) what the numbers of points stand for. The first
/// kMaxScalars of the others whose names can be those of scalar fields become
/// RecordLayout::scalars. `unread` receives the names of the rest, in a form that fits into a
/// one-line message; those called "_" are padding. An error if there is no position.
Result<RecordLayout> layout_of(const std::vector<NamedField>& fields,
                               std::vector<std::string>& unread);

}  // namespace pointreel
