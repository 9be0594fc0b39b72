# What cmake --install, find_package(pointreel) and pkg-config need, and the Debian packages:
# `pointreel` holds the programs, `libpointreel0` the library for C, `python3-pointreel` the module
# for Python, `libpointreel-dev` what other programs are built against.
include(CMakePackageConfigHelpers)

set(libraries pointreel_core pointreel_codec)
if(POINTREEL_BUILD_DRACO)
  list(APPEND libraries pointreel_draco)
endif()
install(TARGETS ${libraries} EXPORT pointreel
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
if(TARGET pointreel_c)
  # An export of its own: programs that link the codec alone do not need the library.
  install(TARGETS pointreel_c EXPORT pointreel-c
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT dev
    PUBLIC_HEADER DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/codec/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT dev)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/pointreel)
install(EXPORT pointreel NAMESPACE pointreel:: FILE pointreel-targets.cmake
  DESTINATION ${package_folder} COMPONENT dev)
if(TARGET pointreel_c)
  install(EXPORT pointreel-c NAMESPACE pointreel:: FILE pointreel-c-targets.cmake
    DESTINATION ${package_folder} COMPONENT dev)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/pointreel-config.cmake.in
  ${PROJECT_BINARY_DIR}/pointreel-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pointreel-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/pointreel-config.cmake
  ${PROJECT_BINARY_DIR}/pointreel-config-version.cmake
  DESTINATION ${package_folder} COMPONENT dev)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright ${PROJECT_SOURCE_DIR}/codec/FORMAT.md
  ${PROJECT_SOURCE_DIR}/common/FORMULAS.md ${PROJECT_SOURCE_DIR}/common/stream/PROTOCOL.md
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/libpointreel-dev COMPONENT dev)
set(pkgconfig_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
# Relative, so that the package works under any prefix.
file(RELATIVE_PATH pkgconfig_to_prefix /${pkgconfig_folder} /)
set(pkgconfig_names pointreel-codec)
if(TARGET pointreel_c)
  list(APPEND pkgconfig_names pointreel)
endif()
foreach(name ${pkgconfig_names})
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${pkgconfig_folder} COMPONENT dev)
endforeach()

set(programs)
foreach(program pointreel pointreel-server pointreel-synth)
  if(TARGET ${program})
    list(APPEND programs ${program})
  endif()
endforeach()
if(programs)
  install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/pointreel COMPONENT programs)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The Pointreel developers <pointreel@localhost>")
set(CPACK_COMPONENTS_ALL dev)
if(programs)
  list(APPEND CPACK_COMPONENTS_ALL programs)
endif()
if(TARGET pointreel_c)
  list(APPEND CPACK_COMPONENTS_ALL library)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/libpointreel${POINTREEL_ABI} COMPONENT library)
endif()
if(TARGET pointreel_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/python3-pointreel COMPONENT python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_STRIP_FILES ON)

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME pointreel)
set(CPACK_DEBIAN_PROGRAMS_DESCRIPTION "${PROJECT_DESCRIPTION}
 A server that encodes and streams sequences of point clouds, and a player.")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
# The player opens OpenGL and EGL when it runs, so they are not found among its libraries.
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "libegl1, libgl1")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "ffmpeg, fonts-dejavu-core, libgl1-mesa-dri")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libpointreel${POINTREEL_ABI})
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "Point clouds that move, for C
 Reads reels and live streams, decodes and encodes frames, and writes packages.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)

if(TARGET pointreel_python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-pointreel)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Point clouds that move, as arrays of numpy
 Reads reels and live streams, decodes and encodes frames, writes packages, and draws pictures.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next_python "${POINTREEL_PYTHON_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3-numpy, \
python3 (>= 3.${POINTREEL_PYTHON_MINOR}), python3 (<< 3.${next_python})")
endif()

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libpointreel-dev)
set(CPACK_DEBIAN_DEV_DESCRIPTION "Point clouds that move, for programs in C and C++
 The header for C, and headers and static libraries of the codec for C++.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libexpected-dev, libglm-dev, libzstd-dev")
if(POINTREEL_BUILD_DRACO)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libdraco-dev")
endif()
if(TARGET pointreel_c)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    ", libpointreel${POINTREEL_ABI} (= ${PROJECT_VERSION})")
endif()
include(CPack)
