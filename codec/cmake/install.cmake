# What cmake --install, find_package(pointreel) and pkg-config need, and two Debian packages:
# `pointreel` holds the programs, `libpointreel-dev` what other programs are built against.
include(CMakePackageConfigHelpers)

set(libraries pointreel_core pointreel_codec)
if(POINTREEL_BUILD_DRACO)
  list(APPEND libraries pointreel_draco)
endif()
install(TARGETS ${libraries} EXPORT pointreel
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/codec/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT dev)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/pointreel)
install(EXPORT pointreel NAMESPACE pointreel:: FILE pointreel-targets.cmake
  DESTINATION ${package_folder} COMPONENT dev)
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
configure_file(${CMAKE_CURRENT_LIST_DIR}/pointreel.pc.in ${PROJECT_BINARY_DIR}/pointreel.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/pointreel.pc DESTINATION ${pkgconfig_folder} COMPONENT dev)

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

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libpointreel-dev)
set(CPACK_DEBIAN_DEV_DESCRIPTION "Octree codec for point clouds that move
 Headers and static libraries to encode and decode the frames of Pointreel.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libexpected-dev, libglm-dev, libzstd-dev")
if(POINTREEL_BUILD_DRACO)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libdraco-dev")
endif()
include(CPack)
