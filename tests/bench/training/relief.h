#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/random.h"

/// Procedural relief, which makes smooth synthetic surfaces rough, creased or hilly.
namespace pointreel::bench {

/// Noise from -1 to 1 with unit wavelength: random values at lattice points, interpolated smoothly
/// (Perlin, "An image synthesizer", 1985, in the variant with values at lattice points).
double lattice_noise(const glm::dvec3& p, std::uint64_t seed);

/// A sum of noises with different wavelengths.
class Relief {
 public:
  /// Wavelengths from `longest` down to `shortest`, each half the previous one. The amplitude is
  /// `amplitude` at the longest wavelength and falls with the wavelength to the power `decay`.
  static Relief fractal(double longest, double shortest, double amplitude, double decay,
                        double creased_share, Random& random);

  double height(const glm::dvec3& p) const;

 private:
  struct Octave {
    glm::dvec3 frequency;  ///< per unit of length, along each axis
    double amplitude;
    bool creased;  ///< sharp valleys between rounded folds
  };

  std::vector<Octave> octaves_;
  std::uint64_t seed_ = 0;
};

}  // namespace pointreel::bench
