#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "client/web/wasm/errors.h"
#include "client/web/wasm/tables.h"
#include "pointreel/draco.h"
#include "tests/golden/cells.h"
#include "tests/golden/known_as_number.h"

// What tests look at besides the functions of module.h: a decoded frame itself, as tests/golden
// records it.

using namespace pointreel;

struct Outcome {
  double depth, points;
  double has_colors, has_normals;
  std::uint64_t cells, colors, normals;  ///< XXH3
};
static_assert(sizeof(Outcome) == 7 * 8);

namespace {

std::string fields;
std::vector<std::uint64_t> hashes;

template <class T>
std::uint64_t hash(const std::vector<T>& values) {
  return XXH3_64bits(values.data(), values.size() * sizeof(T));
}

}  // namespace

/// As pr_prepare, with the default limits or that of the memory; 0 if the frame does not decode.
PR_EXPORT(const Outcome*, pr_test_outcome)
(const std::uint8_t* bytes, const std::uint32_t* sizes, std::uint32_t layers, double max_memory) {
  static Outcome outcome;
  std::vector<Chunks<ByteView>> views;
  for (std::uint32_t i = 0; i < layers; ++i) {
    Chunks<ByteView>& view = views.emplace_back();
    for (ByteView* chunk : {&view.geometry, &view.colors, &view.normals}) {
      *chunk = {bytes, *sizes};
      bytes += *sizes++;
    }
  }
  DecodeLimits limits;
  if (max_memory > 0.0) limits.max_memory = static_cast<std::uint64_t>(max_memory);
  const auto frame = decode_frame(views, limits);
  if (!frame) {
    report(frame.error());
    return nullptr;
  }
  const int depth = frame->svo ? frame->svo->depth : views.front().geometry[6];
  outcome = {static_cast<double>(depth),
             static_cast<double>(frame->cloud.size()),
             frame->cloud.has_colors() ? 1.0 : 0.0,
             frame->cloud.has_normals() ? 1.0 : 0.0,
             hash(golden::cells_of(*frame, depth)),
             hash(frame->cloud.colors),
             hash(frame->cloud.normals)};
  fields.clear();
  for (const ScalarField& field : frame->cloud.scalars) fields += field.name + '\n';
  hashes.clear();
  for (const ScalarField& field : frame->cloud.scalars)
    hashes.push_back(hash(golden::known_as_number(field.values)));
  return &outcome;
}

/// Of the last outcome: the names of scalar fields, in lines, and the XXH3 of the values of each.
PR_EXPORT(const char*, pr_test_fields)() { return fields.c_str(); }
PR_EXPORT(const std::uint64_t*, pr_test_field_hashes)() { return hashes.data(); }
