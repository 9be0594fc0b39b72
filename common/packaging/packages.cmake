# The Debian packages, by `cpack --config build/CPackConfig.cmake`. Each is made of one component of
# what is installed: `pointreel` of the programs, `libpointreel0` of the library for C,
# `python3-pointreel` of the module for Python, `libpointreel-dev` of what other programs are built
# against. common/packaging/debian holds what only packages have.
set(debian ${CMAKE_CURRENT_LIST_DIR}/debian)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The Pointreel developers <pointreel@localhost>")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# Each package has a description of its own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(CPACK_COMPONENTS_ALL)
# What the version of a package depends on is known when it is made.
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_LIST_DIR}/package_version.cmake)
set(CPACK_POINTREEL_SOURCE ${PROJECT_SOURCE_DIR})

find_program(POINTREEL_GZIP gzip REQUIRED)
set(changelog ${PROJECT_BINARY_DIR}/changelog.gz)
execute_process(COMMAND ${POINTREEL_GZIP} -9nc ${debian}/changelog OUTPUT_FILE ${changelog}
  COMMAND_ERROR_IS_FATAL ANY)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${debian}/changelog)

# pointreel_package(NAME COMPONENT [CONTROL FILE...]): the package of a component, with what all
# packages have, and control files such as maintainer scripts.
macro(pointreel_package name component)
  cmake_parse_arguments(package "" "" "CONTROL" ${ARGN})
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_CONTROL_EXTRA ${package_CONTROL})
  install(FILES ${debian}/copyright ${changelog}
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name} COMPONENT ${component})
  install(FILES ${debian}/${name}/lintian-overrides RENAME ${name}
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/lintian/overrides COMPONENT ${component})
endmacro()

if(programs)
  set(control)
  if(TARGET pointreel-server)
    foreach(file conffiles postinst prerm postrm)
      list(APPEND control ${debian}/pointreel/${file})
    endforeach()
    # The service and its configuration are for systems, and so only for the prefix of packages.
    install(CODE "
      if(CMAKE_INSTALL_PREFIX MATCHES \"/usr$\")
        file(INSTALL \"${PROJECT_SOURCE_DIR}/server/systemd/pointreel-server.service\"
          DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib/systemd/system\")
        string(REGEX REPLACE \"/usr$\" \"/etc/pointreel\" folder \"\${CMAKE_INSTALL_PREFIX}\")
        file(INSTALL \"${PROJECT_SOURCE_DIR}/server/systemd/server.toml\" DESTINATION \"\${folder}\")
      endif()" COMPONENT programs)
  endif()
  pointreel_package(pointreel programs CONTROL ${control})
  # The documents and what they link to, in the same folders, so that the links work.
  file(GLOB documents RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS
    *.md client/bindings/README.md client/pictures/*.png client/pictures/*.webp codec/*.md
    common/*.md server/nginx/*)
  foreach(document ${documents})
    cmake_path(GET document PARENT_PATH folder)
    install(FILES ${PROJECT_SOURCE_DIR}/${document}
      DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/pointreel/${folder} COMPONENT programs)
  endforeach()
  # The player for pages of others, if it was made.
  install(DIRECTORY ${PROJECT_BINARY_DIR}/npm/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/pointreel
    COMPONENT programs OPTIONAL FILES_MATCHING PATTERN "*.tgz" PATTERN package EXCLUDE)
  set(CPACK_DEBIAN_PROGRAMS_DESCRIPTION "server and player for point clouds that move
Packs sequences of point clouds, such as scanned people, serves them over
HTTP, and relays live streams. Plays them in a window, in a browser, and
offscreen into pictures and videos.")
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION graphics)
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
  # The player opens OpenGL and EGL when it runs, so they are not found among its libraries.
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "libegl1, libgl1")
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "ffmpeg, fonts-dejavu-core, libgl1-mesa-dri")
endif()

if(TARGET pointreel_c)
  # Programs that other packages build against the library depend on this version or a later one.
  file(WRITE ${PROJECT_BINARY_DIR}/debian/shlibs "libpointreel ${POINTREEL_ABI} \
libpointreel${POINTREEL_ABI} (>= ${PROJECT_VERSION}~)\n")
  file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
  pointreel_package(libpointreel${POINTREEL_ABI} library
    CONTROL ${PROJECT_BINARY_DIR}/debian/shlibs ${PROJECT_BINARY_DIR}/debian/triggers)
  set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "point clouds that move, for C
Reads reels and live streams, decodes and encodes frames, and writes packages.")
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
endif()

if(TARGET pointreel_python)
  pointreel_package(python3-pointreel python
    CONTROL ${debian}/python3-pointreel/postinst ${debian}/python3-pointreel/prerm)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "point clouds that move, as arrays of numpy
Reads reels and live streams, decodes and encodes frames, writes packages,
and draws pictures.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next_python "${POINTREEL_PYTHON_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3-numpy, \
python3 (>= 3.${POINTREEL_PYTHON_MINOR}), python3 (<< 3.${next_python})")
endif()

pointreel_package(libpointreel-dev dev)
set(CPACK_DEBIAN_DEV_DESCRIPTION "point clouds that move, for programs in C and C++
The header for C, and headers and static libraries of the codec for C++.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libexpected-dev, libglm-dev, libzstd-dev")
if(POINTREEL_BUILD_DRACO)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libdraco-dev")
endif()
if(TARGET pointreel_c)
  # package_version.cmake puts the version here.
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libpointreel${POINTREEL_ABI} (= VERSION)")
endif()
include(CPack)
