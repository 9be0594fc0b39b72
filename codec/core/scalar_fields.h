#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// What the values of a scalar field are like.
struct ScalarSummary {
  std::size_t known = 0;           ///< values that are finite
  double least = 0.0, most = 0.0;  ///< of those
  bool whole = false;              ///< all of them are whole numbers
  std::size_t distinct = 0;        ///< how many, where they are whole and span at most 255

  double range() const { return most - least; }
  /// Whether they look like labels, such as classes: a few whole numbers close together. No mean of
  /// labels is ever taken.
  bool labels() const { return distinct > 0 && distinct <= 32; }
};

/// O(n).
ScalarSummary summary_of(std::span<const float> values);

/// The ranges of a cloud's fields, without those that have no known value.
std::vector<ScalarRange> ranges_of(const PointCloud& cloud);
/// Makes `all` cover `more`, too. No more than kMaxScalars fields are kept.
void cover(std::vector<ScalarRange>& all, const std::vector<ScalarRange>& more);

/// Names the layer of scalar fields, unless it is named already.
void add_scalar_layer(std::vector<std::string>& layer_names);

/// Checks the names, the number and the lengths of a cloud's fields. Error: `argument`.
Result<void> check_scalars(const PointCloud& cloud);

}  // namespace pointreel
