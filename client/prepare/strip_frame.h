#pragma once

#include "client/scene/frame.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Makes the strips of a frame that was prepared to be drawn as surfels. The cloud becomes their
/// vertices, one for each leaf of a tree: the leaves of the frame's tree, or those of one that is
/// divided until nearly every point of the cloud has a leaf of its own, where points that share one
/// become one in their middle. The tree itself is dropped.
void make_strips(SceneFrame& scene, const Executor& executor);

}  // namespace pointreel
