#pragma once

#include "client/ui/controls.h"
#include "client/ui/timeline.h"

namespace pointreel {

/// What the bar shows of controls.reel(), or of live streams if that is null.
TimelineView timeline_view(const Controls& controls, Controls::Now now);

}  // namespace pointreel
