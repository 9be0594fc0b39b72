# cmake -D OUTPUT=shaders.cpp -D ROOT=FOLDER -D SHADERS=a.glsl,b/c.glsl -P embed_shaders.cmake
# Writes a C++ source that contains the given files of ROOT as text (see shaders.h).
string(REPLACE "," ";" shaders "${SHADERS}")
set(source "// Made by embed_shaders.cmake.\n#include \"client/render/opengl/shaders.h\"\n\n")
string(APPEND source "namespace pointreel {\n\nstd::string_view shader_source(std::string_view file) {\n")
foreach(name IN LISTS shaders)
  file(READ ${ROOT}/${name} text)
  string(APPEND source "  if (file == \"${name}\") {\n    return R\"glsl(${text})glsl\";\n  }\n")
endforeach()
string(APPEND source "  return {};\n}\n\n}  // namespace pointreel\n")
file(WRITE ${OUTPUT} "${source}")
