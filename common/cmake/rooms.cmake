# A room is a folder of sources with one purpose, and a library of its own. A room links the rooms
# that it uses, and no others.

# What everything in this repository is compiled with. Not installed: users choose their own flags.
add_library(pointreel_flags INTERFACE)
# Fused multiply-add would make quantisation depend on the compiler and the processor. Encoded bytes
# must not.
target_compile_options(pointreel_flags INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -ffp-contract=off)
target_compile_definitions(pointreel_flags INTERFACE GLM_FORCE_EXPLICIT_CTOR)
target_include_directories(pointreel_flags INTERFACE ${PROJECT_SOURCE_DIR})
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  # Below this level the octree's population counts are function calls. Every processor since 2009
  # has it.
  target_compile_options(pointreel_flags INTERFACE -march=x86-64-v2)
endif()
if(POINTREEL_SANITIZE)
  # Not vptr: to look at an object it opens a pipe, and reports a fault if that fails. It does where
  # a test leaves the server without file descriptors.
  target_compile_options(pointreel_flags INTERFACE -fsanitize=address,undefined
    -fno-sanitize=vptr -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(pointreel_flags INTERFACE -fsanitize=address,undefined)
endif()
if(POINTREEL_SANITIZE_THREADS)
  # ThreadSanitizer does not know Asio's own fences, and warns at each of them.
  target_compile_options(pointreel_flags INTERFACE
    -fsanitize=thread -fno-omit-frame-pointer -Wno-tsan)
  target_link_options(pointreel_flags INTERFACE -fsanitize=thread)
endif()
if(POINTREEL_FUZZ)
  target_compile_options(pointreel_flags INTERFACE
    -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined)
  target_link_options(pointreel_flags INTERFACE -fsanitize=address,undefined)
endif()

# pointreel_room(NAME SOURCES... [USES LIBRARY...] [PRIVATE LIBRARY...])
#
# A static library. With tests on, a program is linked from all of its objects and what it uses
# alone: a room that reaches for one that it does not declare fails to link.
function(pointreel_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "" "" "SOURCES;USES;PRIVATE")
  add_library(${name} STATIC ${room_SOURCES})
  target_link_libraries(${name} PUBLIC ${room_USES}
    PRIVATE ${room_PRIVATE} $<BUILD_INTERFACE:pointreel_flags>)
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
endfunction()

# Compiling a source full of Boost.Beast templates with both sanitizers and optimisation takes seven
# minutes and 4 GB. These sources go without optimisation and without the second sanitizer.
function(pointreel_compile_lightly)  # SOURCES...
  if(POINTREEL_SANITIZE OR POINTREEL_SANITIZE_THREADS)
    set_property(SOURCE ${ARGV} APPEND PROPERTY COMPILE_OPTIONS -O0 -fno-sanitize=undefined)
  endif()
endfunction()
