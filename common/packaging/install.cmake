# What cmake --install, find_package(pointreel) and pkg-config need.
include(CMakePackageConfigHelpers)

set(libraries pointreel_base pointreel_core pointreel_codec)
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
configure_package_config_file(${PROJECT_SOURCE_DIR}/codec/cmake/pointreel-config.cmake.in
  ${PROJECT_BINARY_DIR}/pointreel-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pointreel-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/pointreel-config.cmake
  ${PROJECT_BINARY_DIR}/pointreel-config-version.cmake
  DESTINATION ${package_folder} COMPONENT dev)
install(FILES ${PROJECT_SOURCE_DIR}/codec/FORMAT.md
  ${PROJECT_SOURCE_DIR}/common/FORMULAS.md ${PROJECT_SOURCE_DIR}/common/PROTOCOL.md
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/libpointreel-dev COMPONENT dev)
set(pkgconfig_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
# Relative, so that the package works under any prefix.
file(RELATIVE_PATH pkgconfig_to_prefix /${pkgconfig_folder} /)
set(pkgconfig_names pointreel-codec)
if(TARGET pointreel_c)
  list(APPEND pkgconfig_names pointreel)
endif()
foreach(name ${pkgconfig_names})
  configure_file(${PROJECT_SOURCE_DIR}/codec/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
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
endif()
# Manual pages and completions, which the programs make of their options. Builds with sanitizers are
# not for installing.
if(programs AND NOT POINTREEL_SANITIZE AND NOT POINTREEL_SANITIZE_THREADS)
  set(manuals ${PROJECT_BINARY_DIR}/manuals)
  set(write_manuals)
  foreach(program ${programs})
    list(APPEND write_manuals COMMAND ${program} --write-manuals ${manuals})
  endforeach()
  find_program(POINTREEL_GZIP gzip REQUIRED)
  add_custom_command(OUTPUT ${manuals}.made
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${manuals}
    ${write_manuals}
    COMMAND find ${manuals}/man -name *.1 -exec ${POINTREEL_GZIP} -9n {} +
    COMMAND ${CMAKE_COMMAND} -E touch ${manuals}.made
    DEPENDS ${programs} COMMENT "Writing manual pages and completions" VERBATIM)
  add_custom_target(pointreel_manuals ALL DEPENDS ${manuals}.made)
  install(DIRECTORY ${manuals}/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR} COMPONENT programs)
endif()
add_custom_target(programs DEPENDS ${programs})
