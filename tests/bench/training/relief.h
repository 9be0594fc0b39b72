#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/random.h"

/// Procedural relief: what makes a smooth synthetic surface rough, creased or hilly.
namespace pointreel::bench {

/// Noise on a lattice, -1 to 1, smooth between lattice points (Perlin, "An image synthesizer",
/// 1985, in the form with values at lattice points). Unit wavelength.
double lattice_noise(const glm::dvec3& p, std::uint64_t seed);

/// A sum of noises of different wavelengths.
class Relief {
 public:
  struct Octave {
    glm::dvec3 frequency;  ///< per unit of length, along each axis
    double amplitude;
    bool creased;  ///< sharp valleys between rounded folds
  };

  /// From `longest` wavelength down to `shortest`, each half the one before; amplitudes fall with
  /// the wavelength to the power `decay` from `amplitude` at the longest.
  static Relief fractal(double longest, double shortest, double amplitude, double decay,
                        double creased_share, Random& random);

  double height(const glm::dvec3& p) const;

 private:
  std::vector<Octave> octaves_;
  std::uint64_t seed_ = 0;
};

}  // namespace pointreel::bench
