// An instance from vertex attributes.
layout(location = 0) in vec4 center_radius;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;

Instance fetch_instance() { return Instance(center_radius.xyz, center_radius.w, normal, color); }
