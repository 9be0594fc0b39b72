#include "tests/stability/check.h"

#include <iterator>

namespace pointreel::stability {

nlohmann::json to_json(const Check& check) {
  return {{"stage", check.stage},
          {"subject", check.subject},
          {"required", check.required},
          {"outcome", check.outcome},
          {"passed", check.passed}};
}

Checks run_stability_checks() {
  Checks all;
  for (const auto stage :
       {ingest_checks, quantisation_checks, octree_checks, drawing_checks, temporal_checks,
        stream_checks, coordinate_checks, delta_checks, depth_checks, determinism_checks}) {
    Checks some = stage();
    all.insert(all.end(), std::make_move_iterator(some.begin()),
               std::make_move_iterator(some.end()));
  }
  return all;
}

std::vector<HardRow> hard_rows() {
  const std::string opengl = "on the graphics card: tests/client/renderer_test.cpp";
  const std::string not_built = "not built yet";
  return {
      {"ingest", "NaN or infinite position", ""},
      {"ingest", "far coordinates", ""},
      {"ingest", "unusable normal", ""},
      {"ingest", "unusable radius", ""},
      {"ingest", "ascii", ""},
      {"ingest", "little endian", ""},
      {"ingest", "big endian", ""},
      {"ingest", "scalar types", ""},
      {"ingest", "double positions", ""},
      {"ingest", "16-bit colours", ""},
      {"ingest", "float colours", ""},
      {"ingest", "no colours", ""},
      {"ingest", "list properties", ""},
      {"ingest", "faces", ""},
      {"ingest", "CRLF", ""},
      {"ingest", "comments", ""},
      {"ingest", "trailing garbage", ""},
      {"ingest", "header larger than the data", ""},
      {"quantisation", "maximum face", ""},
      {"quantisation", "no extent", ""},
      {"octree", "no points", ""},
      {"octree", "identical points", ""},
      {"octree", "delta out of range", ""},
      {"octree", "level 21", ""},
      {"octree", "input order and threads", ""},
      {"surfel frame", "poles", ""},
      {"level of detail", "eye inside a node", ""},
      {"level of detail", "at the near plane", ""},
      {"level of detail", "behind the eye", ""},
      {"normal cone", "half-angle of 90 degrees, opposed normals", not_built},
      {"splat", "edge-on, crossing the near plane", opengl},
      {"blending", "no weight, thousands of contributions", opengl},
      {"APSS", "degenerate fits", not_built},
      {"Delaunay", "collinear, cocircular, duplicates", not_built},
      {"depth", "far over near of 1e5", ""},
      {"temporal", "point count changes by 10x", ""},
      {"temporal", "frame missing or late", ""},
      {"temporal", "first frame of a group lost", ""},
      {"stream", "truncated at every byte", ""},
      {"stream", "every bit flipped", ""},
      {"stream", "counts of 2^32", ""},
      {"stream", "level sizes that disagree with popcounts", ""},
  };
}

}  // namespace pointreel::stability
