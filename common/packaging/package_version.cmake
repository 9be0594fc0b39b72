# Read by cpack: the version of the packages. The commit of a release, which has the tag v0.1.0, gives
# 0.1.0. Commits before it give 0.1.0~dev1234.abcdef0, where 1234 is the number of commits so far: a
# later one is a newer version to apt, and the release is newer than all of them. Sources without
# git give 0.1.0.
function(ask_git result)
  execute_process(COMMAND git -C ${CPACK_POINTREEL_SOURCE} ${ARGN}
    RESULT_VARIABLE status OUTPUT_VARIABLE answer ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT status EQUAL 0)
    set(answer "")
  endif()
  set(${result} "${answer}" PARENT_SCOPE)
endfunction()

ask_git(release tag --points-at HEAD --list v${CPACK_PACKAGE_VERSION})
ask_git(count rev-list --count HEAD)
ask_git(commit rev-parse --short HEAD)
set(CPACK_DEBIAN_PACKAGE_VERSION ${CPACK_PACKAGE_VERSION})
if(count AND commit AND NOT release)
  string(APPEND CPACK_DEBIAN_PACKAGE_VERSION "~dev${count}.${commit}")
endif()
string(REPLACE "VERSION" "${CPACK_DEBIAN_PACKAGE_VERSION}" CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "${CPACK_DEBIAN_DEV_PACKAGE_DEPENDS}")
