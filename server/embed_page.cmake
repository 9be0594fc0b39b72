# cmake -D OUTPUT=built_in_page.cpp -D PAGE=FOLDER -P embed_page.cmake
# Writes a C++ source that contains index.html and the files of page/ below the folder, with their
# forms compressed by brotli (.br) and gzip (.gz), as built_in_page().
file(GLOB_RECURSE files RELATIVE ${PAGE}/page ${PAGE}/page/*)
list(APPEND files ../index.html)
list(FILTER files EXCLUDE REGEX "\\.(br|gz)$")
set(data "")
set(table "")
set(number 0)
foreach(name IN LISTS files)
  set(file ${PAGE}/page/${name})
  string(REPLACE "../" "" name ${name})
  set(views "")
  foreach(form "" .br .gz)
    if(EXISTS ${file}${form})
      set(symbol pointreel_page_${number})
      math(EXPR number "${number} + 1")
      string(APPEND data
        "__asm__(\".section .rodata\\n${symbol}:\\n.incbin \\\"${file}${form}\\\"\\n\"\n"
        "        \"${symbol}_end:\\n.previous\\n\");\n"
        "extern \"C\" const char ${symbol}[], ${symbol}_end[];\n")
      string(APPEND views ", text(${symbol}, ${symbol}_end)")
    else()
      string(APPEND views ", {}")
    endif()
  endforeach()
  string(APPEND table "      {\"${name}\"${views}},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by embed_page.cmake.
#include <array>
#include <cstddef>

#include \"server/built_in_page.h\"

${data}
namespace pointreel {

std::span<const PageFile> built_in_page() {
  const auto text = [](const char* begin, const char* end) {
    return std::string_view(begin, static_cast<std::size_t>(end - begin));
  };
  static const auto files = std::to_array<PageFile>({
${table}  });
  return files;
}

}  // namespace pointreel
")
