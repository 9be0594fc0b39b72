#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// The numerical stability of Pointreel as a list of checks with measured outcomes. The unit tests
/// assert them, and the report of pointreel-bench prints them.
namespace pointreel::stability {

/// A hard case at one stage. The requirement and the outcome are short phrases for people; the
/// outcome includes figures.
struct Check {
  std::string stage;    ///< such as "ingest"
  std::string subject;  ///< the hard case, such as "no extent"
  std::string required;
  std::string outcome;
  bool passed = false;
};

using Checks = std::vector<Check>;

nlohmann::json to_json(const Check& check);

// There is one function for each stage. None of them takes much longer than a second.
Checks ingest_checks();        ///< the files of `pointreel-synth hard`
Checks quantisation_checks();  ///< points on the maximum face, no extent
Checks octree_checks();        ///< no points, identical points, invalid deltas, level 21
Checks drawing_checks();       ///< surfel frames, level of detail, depth
Checks temporal_checks();      ///< frames of varying size, missing and late frames
Checks stream_checks();        ///< damaged and forged frames, manifests and files
Checks coordinate_checks();    ///< coordinates far from zero
Checks delta_checks();         ///< delta from 0 to 0.9
Checks depth_checks();         ///< each depth from 0 to 21
Checks determinism_checks();   ///< order of points, threads, exact round trips

/// Runs all of them in this order.
Checks run_stability_checks();

/// A hard case that the project must handle. It is checked here, unless `elsewhere` says why not.
struct HardRow {
  std::string stage, subject;
  std::string elsewhere;
};
std::vector<HardRow> hard_rows();

}  // namespace pointreel::stability
