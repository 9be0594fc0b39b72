#pragma once

#include <memory>

#include "client/scene/frame.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Makes the strips of a frame that was prepared to be drawn as surfels. The cloud becomes their
/// vertices, one for each leaf of a tree: the leaves of the frame's tree, or those of one that is
/// divided until nearly every point of the cloud has a leaf of its own, where points that share one
/// become one in their middle. The tree itself is dropped.
///
/// If there is a place for a record, what an earlier frame's record there has in common with this
/// one is not made again, and the record becomes this frame's (update_strips). The strips are the
/// same.
void make_strips(SceneFrame& scene, const Executor& executor,
                 std::shared_ptr<const StripRecord>* record = nullptr);

}  // namespace pointreel
