#include "codec/files/column_guess.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "common/base/concat.h"

namespace pointreel {
namespace {

using Names = std::vector<std::string>;

void add(Names& names, std::initializer_list<const char*> more) {
  names.insert(names.end(), more.begin(), more.end());
}

Names numbered_up_to(Names names, std::size_t columns) {
  for (std::size_t i = names.size(); i < columns; ++i) names.push_back(concat("column ", i + 1));
  return names;
}

}  // namespace

void ColumnGuess::see(const double* row, std::size_t columns) {
  for (std::size_t i = 3; i < std::min(columns, kMost); ++i) {
    looks_[i].whole &= row[i] >= 0.0 && row[i] == std::floor(row[i]);
    looks_[i].bytes &= row[i] <= 255.0;
    looks_[i].negative |= row[i] < 0.0;
    if (rows_ == 0) looks_[i].first = row[i];
    looks_[i].varies |= row[i] != looks_[i].first;
  }
  ++rows_;
  if (columns < 6) return;
  const double length = row[3] * row[3] + row[4] * row[4] + row[5] * row[5];
  unit_ += std::abs(length - 1.0) < 0.01;
}

bool ColumnGuess::are_bytes(std::size_t at) const {
  return std::all_of(looks_.begin() + static_cast<std::ptrdiff_t>(at),
                     looks_.begin() + static_cast<std::ptrdiff_t>(at) + 3,
                     [](const Look& look) { return look.whole && look.bytes; });
}

bool ColumnGuess::are_normals() const {
  return looks_[3].negative || looks_[4].negative || looks_[5].negative || unit_ * 10 > rows_ * 9;
}

Names ColumnGuess::text_names(std::size_t columns, bool pts) const {
  Names names{"x", "y", "z"};
  if (columns == 4) add(names, {"intensity"});
  if (columns == 7 && (pts || (are_bytes(4) && !are_bytes(3)))) {
    add(names, {"intensity", "r", "g", "b"});
  } else if (columns == 6 && !pts && are_normals()) {
    add(names, {"nx", "ny", "nz"});
  } else if (columns == 6 || columns == 7 || columns == 9 || columns == 10) {
    add(names, {"r", "g", "b"});
  }
  if (columns == 9 || columns == 10) add(names, {"nx", "ny", "nz"});
  if (columns == 10 || (columns == 7 && names.size() == 6)) add(names, {"intensity"});
  return numbered_up_to(std::move(names), columns);
}

Names ColumnGuess::sweep_names(std::size_t floats) const {
  Names names{"x", "y", "z"};
  if (floats == 6 && are_bytes(3)) {
    add(names, {"r", "g", "b"});
  } else if (floats == 6 && unit_ * 10 > rows_ * 9) {
    add(names, {"nx", "ny", "nz"});
  } else if (floats == 7 && are_bytes(4)) {
    add(names, {"intensity", "r", "g", "b"});
  } else {
    if (floats > 3) add(names, {"intensity"});
    const bool ring = looks_[4].whole && looks_[4].bytes;
    // A number that never varies says nothing.
    if (floats > 4) add(names, {!looks_[4].varies ? "_" : ring ? "ring" : "time"});
    if (floats > 5 && ring && !looks_[5].whole) add(names, {"time"});
  }
  return numbered_up_to(std::move(names), floats);
}

}  // namespace pointreel
