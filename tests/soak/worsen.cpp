#include "tests/soak/scenario.h"

namespace pointreel::soak {

void worsen(LinkEmulator& link, std::mt19937_64& random) {
  using std::chrono::milliseconds;
  const auto one_in = [&random](unsigned n) { return random() % n == 0; };
  LinkConditions bad;
  bad.bits_per_second = 1'000'000u << random() % 8;
  bad.delay = milliseconds(random() % 20);
  if (one_in(4)) bad.split = 1 + random() % 100;
  if (one_in(3)) bad.corrupt_every = 20'000;
  if (one_in(6)) bad.truncate_after = 1 + random() % 50'000;
  if (one_in(6)) bad.reset_after = 1 + random() % 50'000;
  bad.cut = one_in(8);
  link.set(bad);
  if (one_in(4)) link.reset_connections();
  if (one_in(8)) link.forget_connections();
}

}  // namespace pointreel::soak
