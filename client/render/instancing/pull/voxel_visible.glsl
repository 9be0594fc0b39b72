// The cut of the octree has left out what cannot be seen.
bool visible(Instance voxel) { return true; }
