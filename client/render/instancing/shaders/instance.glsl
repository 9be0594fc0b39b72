// What is drawn once for each point or voxel, as instance_buffer.h packs it.
struct Instance {
  vec3 center;
  float radius;  // of the splat, or half the voxel's edge
  vec3 normal;   // unit length, or zero where unknown
  vec3 color;    // linear
};

Instance unpack_instance(uvec4 first, uvec4 second) {
  return Instance(uintBitsToFloat(first.xyz), uintBitsToFloat(first.w),
                  vec3(unpackSnorm2x16(second.x), unpackSnorm2x16(second.y).x),
                  vec3(unpackHalf2x16(second.z), unpackHalf2x16(second.w).x));
}
