# A room is a folder of sources with one purpose, and a library of its own. It links the rooms that
# it uses, and no others.

# The flags that everything in this repository is compiled with. They are not installed: other
# programs choose their own.
add_library(pointreel_flags INTERFACE)
# Without -ffp-contract=off, fused multiply-add would make quantisation, and so the encoded bytes,
# depend on the compiler and the processor.
target_compile_options(pointreel_flags INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  # libstdc++ 12 uses a function of its own that it has deprecated, in std::stable_sort.
  target_compile_options(pointreel_flags INTERFACE -Wno-deprecated-declarations)
endif()
target_compile_definitions(pointreel_flags INTERFACE GLM_FORCE_EXPLICIT_CTOR)
target_include_directories(pointreel_flags INTERFACE ${PROJECT_SOURCE_DIR})
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  # All processors since 2009 support this level. Below it, counting the octree's bits takes function
  # calls.
  target_compile_options(pointreel_flags INTERFACE -march=x86-64-v2)
endif()
if(POINTREEL_SANITIZE)
  # Without vptr, because this check opens a pipe and reports an error if it cannot, as in a test
  # that leaves the server without file descriptors.
  target_compile_options(pointreel_flags INTERFACE -fsanitize=fuzzer-no-link,address,undefined
    -fno-sanitize=vptr -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(pointreel_flags INTERFACE -fsanitize=address,undefined)
  # libFuzzer looks at the counters of all code after each input, so code that nothing calls is left
  # out.
  target_compile_options(pointreel_flags INTERFACE -ffunction-sections)
  target_link_options(pointreel_flags INTERFACE LINKER:--gc-sections,-z,start-stop-gc)
endif()
if(POINTREEL_SANITIZE_THREADS)
  # ThreadSanitizer does not understand Asio's fences, and g++ warns at each of them.
  target_compile_options(pointreel_flags INTERFACE
    -fsanitize=thread -fno-omit-frame-pointer -Wno-tsan)
  target_link_options(pointreel_flags INTERFACE -fsanitize=thread)
endif()

# Release builds compile what has no loops over points or bytes with less optimisation, which
# takes three quarters of the time.
function(pointreel_compile_cold target)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O1)
  endif()
endfunction()

# pointreel_room(NAME [COLD] SOURCES... [USES LIBRARY...] [PRIVATE LIBRARY...])
#
# Makes a static library. COLD: as pointreel_compile_cold. If tests are built, all of its objects are also linked to a program with
# the rooms that it declares and nothing else, which fails if it uses a room that it does not declare.
function(pointreel_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "COLD" "" "SOURCES;USES;PRIVATE")
  add_library(${name} STATIC ${room_SOURCES})
  target_link_libraries(${name} PUBLIC ${room_USES}
    PRIVATE ${room_PRIVATE} $<BUILD_INTERFACE:pointreel_flags>)
  if(room_COLD)
    pointreel_compile_cold(${name})
  endif()
  if(POINTREEL_BUILD_TESTS)
    add_executable(${name}_floor ${PROJECT_SOURCE_DIR}/common/cmake/floor.cpp)
    target_link_libraries(${name}_floor PRIVATE pointreel_flags
      $<LINK_LIBRARY:WHOLE_ARCHIVE,${name}>)
    set_target_properties(${name}_floor PROPERTIES
      RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/floors)
  endif()
endfunction()

# pointreel_program(NAME SOURCES... [USES LIBRARY...])
function(pointreel_program name)
  cmake_parse_arguments(PARSE_ARGV 1 program "" "" "SOURCES;USES")
  add_executable(${name} ${program_SOURCES})
  target_link_libraries(${name} PRIVATE ${program_USES} pointreel_flags)
  pointreel_use_huge_pages(${name})
endfunction()

# Sanitizers have an allocator of their own.
function(pointreel_use_huge_pages program)
  if(NOT (POINTREEL_SANITIZE OR POINTREEL_SANITIZE_THREADS))
    target_sources(${program} PRIVATE ${PROJECT_SOURCE_DIR}/common/process/huge_pages.cpp)
  endif()
endfunction()

# A source full of Boost.Beast templates takes seven minutes and 4 GB to compile with optimisation
# and both sanitizers. In sanitized builds, this turns optimisation and the second sanitizer off.
function(pointreel_compile_lightly)  # SOURCES...
  if(POINTREEL_SANITIZE OR POINTREEL_SANITIZE_THREADS)
    set_property(SOURCE ${ARGV} APPEND PROPERTY COMPILE_OPTIONS -O0 -fno-sanitize=undefined)
  endif()
endfunction()
