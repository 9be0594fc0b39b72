#pragma once

#include "client/session/report.h"
#include "client/ui/controls.h"

namespace pointreel {

/// Notes what plays and what is open at the end.
void describe_end(const Controls& controls, Controls::Now now, WindowReport& report);

}  // namespace pointreel
