#pragma once

#include <memory>

#include "pointreel/codec.h"

/// A handle of module.h.
struct PrTables {
  std::shared_ptr<const pointreel::ContextTables> tables;
};
