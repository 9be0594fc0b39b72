// A surfel, voxel or point, as instance_buffer.h packs it.
struct Instance {
  vec3 center;
  float radius;  // of the splat, or half the edge of the voxel
  vec3 normal;   // unit length, or zero if unknown
  vec3 color;    // linear
};

Instance unpack_instance(uvec4 first, uvec4 second) {
  return Instance(uintBitsToFloat(first.xyz), uintBitsToFloat(first.w),
                  vec3(unpackSnorm2x16(second.x), unpackSnorm2x16(second.y).x),
                  vec3(unpackHalf2x16(second.z), unpackHalf2x16(second.w).x));
}
