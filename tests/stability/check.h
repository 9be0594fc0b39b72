#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// The numerical stability of Pointreel as a list of checks with measured outcomes: what CI asserts
/// and what the report prints are the same.
namespace pointreel::stability {

/// One hard case at one stage. What is required and what came out are short phrases for a person,
/// the outcome with its figures.
struct Check {
  std::string stage;    ///< such as "ingest"
  std::string subject;  ///< the hard case, such as "no extent"
  std::string required;
  std::string outcome;
  bool passed = false;
};

using Checks = std::vector<Check>;

nlohmann::json to_json(const Check& check);

// One function for each stage; none takes much longer than a second.
Checks ingest_checks();        ///< the files of `pointreel-synth hard`
Checks quantisation_checks();  ///< points on the maximum face, no extent
Checks octree_checks();        ///< no points, identical points, deltas that are none, level 21
Checks drawing_checks();       ///< surfel frames, the level of detail, depth
Checks temporal_checks();      ///< frames of other sizes, missing and late ones
Checks stream_checks();        ///< damaged and forged frames, manifests and files
Checks coordinate_checks();    ///< coordinates far from zero
Checks delta_checks();         ///< delta from 0 to 0.9
Checks depth_checks();         ///< each depth from 0 to 21
Checks determinism_checks();   ///< order of points, threads, exact round trips

/// All of them, in this order.
Checks run_stability_checks();

/// A row of the project's table of hard cases: it is checked here, or `elsewhere` says why not.
struct HardRow {
  std::string stage, subject;
  std::string elsewhere;
};
std::vector<HardRow> hard_rows();

}  // namespace pointreel::stability
