uint kind_of(Instance voxel) { return kind_of(voxel.center, 1.73206 * voxel.radius); }
