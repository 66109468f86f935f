# An overlay port: vcpkg install htree --overlay-ports=packaging/vcpkg. It builds the checkout that it lies in.
# The ABI is C's and there is no debug run-time to match, so one build serves both configurations.
set(VCPKG_BUILD_TYPE release)
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../.." ABSOLUTE)
find_program(MAKE make REQUIRED)
vcpkg_cmake_get_vars(cmake_vars_file)
include("${cmake_vars_file}")

set(flags "${VCPKG_DETECTED_CMAKE_C_FLAGS} ${VCPKG_DETECTED_CMAKE_C_FLAGS_RELEASE}")
set(ours "CC=${VCPKG_DETECTED_CMAKE_C_COMPILER}" "CFLAGS=${flags}" "B=${CURRENT_BUILDTREES_DIR}/${TARGET_TRIPLET}"
    "PREFIX=${CURRENT_PACKAGES_DIR}" "cmakedir=${CURRENT_PACKAGES_DIR}/share/${PORT}" "PROGRAMS=" "PKG_CONFIG=false")
if(NOT "opencl" IN_LIST FEATURES)
  list(APPEND ours "HAVE_OPENCL=")
endif()
vcpkg_execute_required_process(COMMAND "${MAKE}" install ${ours}
  WORKING_DIRECTORY "${SOURCE_PATH}" LOGNAME "install-${TARGET_TRIPLET}")

# One linkage a triplet: the other one goes.
if(VCPKG_LIBRARY_LINKAGE STREQUAL "static")
  file(GLOB other "${CURRENT_PACKAGES_DIR}/lib/*.so*")
  vcpkg_replace_string("${CURRENT_PACKAGES_DIR}/share/${PORT}/htree-config.cmake"
    "if(HTREE_STATIC)" "if(TRUE)")
else()
  file(GLOB other "${CURRENT_PACKAGES_DIR}/lib/*.a")
endif()
file(REMOVE ${other})
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/share/doc" "${CURRENT_PACKAGES_DIR}/share/man")
file(INSTALL "${CURRENT_PORT_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
