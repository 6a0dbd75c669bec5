# SPDX-License-Identifier: Apache-2.0
# Debian packages, made by `cpack -G DEB` in the build folder: binnacle (component runtime), binnacle-dev (dev); where there
# is an MPI, binnacle-mpi (mpi); where the Python package is built, python3-binnacle (python); where the manual was built as a
# site, binnacle-doc (doc).
include_guard(GLOBAL)

# Who answers for the packages that are built here, and where they are from: whoever distributes them sets these.
set(BINNACLE_MAINTAINER "The Binnacle maintainers <maintainers@binnacle.invalid>" CACHE STRING "Maintainer of the Debian packages")
set(BINNACLE_HOMEPAGE "" CACHE STRING "Homepage of the Debian packages")
# sdk/dist/build gives those of each Debian one of their own, 1+deb12: their files lie in one folder, and a newer Debian upgrades.
set(BINNACLE_PACKAGE_RELEASE 1 CACHE STRING "Release of the Debian packages")

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_PACKAGE_VENDOR "Binnacle")
set(CPACK_PACKAGE_CONTACT "${BINNACLE_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
# Each package has a synopsis of its own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE "${BINNACLE_PACKAGE_RELEASE}")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_HOMEPAGE "${BINNACLE_HOMEPAGE}")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)  # whatever the umask of the checkout was
set(this_version "= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")

set(what_it_is "Binnacle composes error-state Kalman filters for INS/GNSS and other sensors
from JSON files, out of plugins, and runs them on recorded, live or simulated
data.
.
")

set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "error-state Kalman filters for INS/GNSS, composed from JSON
${what_it_is}This package has the command, its plugins, configs to start from, the manual,
and the library of the C interface.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME binnacle)
# The library of the C interface: who links it needs the plugins too.
get_target_property(c_version binnacle_c SOVERSION)
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/package/shlibs"
  CONTENT "libbinnacle_c ${c_version} binnacle (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA "${PROJECT_BINARY_DIR}/package/shlibs" "${CMAKE_CURRENT_LIST_DIR}/debian/triggers")
# NetCDF is loaded by name, when results are written or read: --out. With what it needs it is larger than all else together
# (57 MB on Debian 12), so it is suggested; the first --out names it. Python runs configs/benchmarks/run alone.
get_property(netcdf_package GLOBAL PROPERTY BINNACLE_NETCDF_PACKAGE)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "${netcdf_package}, graphviz, python3, binnacle-dev, python3-binnacle")

set(CPACK_DEBIAN_DEV_DESCRIPTION "error-state Kalman filters for INS/GNSS - development files
${what_it_is}This package has the headers, libraries and CMake package for plugins, and for
programs that embed a filter.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME binnacle-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "binnacle (${this_version}), libeigen3-dev")
# Only an embedding program needs these.
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "nlohmann-json3-dev, libboost-dev, libboost-filesystem-dev")

if(TARGET binnacle_mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
  set(CPACK_DEBIAN_MPI_DESCRIPTION "error-state Kalman filters for INS/GNSS - studies under MPI
${what_it_is}This package lets 'binnacle study' run under mpirun, on several machines.")
  set(CPACK_DEBIAN_MPI_PACKAGE_NAME binnacle-mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "binnacle (${this_version})")
  set(CPACK_DEBIAN_MPI_PACKAGE_RECOMMENDS "openmpi-bin")
endif()

if(TARGET binnacle_python)
  get_property(python_version GLOBAL PROPERTY BINNACLE_PYTHON_VERSION)
  list(APPEND CPACK_COMPONENTS_ALL python)
  string(REGEX MATCH "[0-9]+$" minor "${python_version}")
  math(EXPR minor "${minor} + 1")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "error-state Kalman filters for INS/GNSS - Python package
${what_it_is}This package runs the same filters in Python: runs, sessions, studies and
results as numpy arrays, and models written in Python.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-binnacle)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # The module is of one version of Python.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "binnacle (${this_version}), python3 (>= ${python_version}), python3 (<< 3.${minor}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-pandas, python3-xarray, python3-matplotlib")
  # Byte code is made when it is installed, and leaves with it.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${CMAKE_CURRENT_LIST_DIR}/debian/postinst" "${CMAKE_CURRENT_LIST_DIR}/debian/prerm")
endif()

if(EXISTS "${PROJECT_SOURCE_DIR}/build/site/index.html")
  list(APPEND CPACK_COMPONENTS_ALL doc)
  set(CPACK_DEBIAN_DOC_DESCRIPTION "error-state Kalman filters for INS/GNSS - manual as a site
${what_it_is}This package has the manual as pages for a browser, with a search and the API.")
  set(CPACK_DEBIAN_DOC_PACKAGE_NAME binnacle-doc)
  set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
  set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
endif()

# ---- what Debian wants of each package: copyright, changelogs; of lintian's warnings those that stay, with a reason

set(debian "${CMAKE_CURRENT_LIST_DIR}/debian")
set(changelogs "${PROJECT_BINARY_DIR}/package/changelogs")
find_program(BINNACLE_GZIP gzip)
mark_as_advanced(BINNACLE_GZIP)
if(BINNACLE_GZIP)
  add_custom_command(
    OUTPUT "${changelogs}/changelog.Debian.gz" "${changelogs}/changelog.gz"
    COMMAND sh "${debian}/changelogs.sh" "${PROJECT_SOURCE_DIR}/CHANGELOG.md" ${CPACK_DEBIAN_PACKAGE_RELEASE}
      "${BINNACLE_MAINTAINER}" "${changelogs}"
    DEPENDS "${PROJECT_SOURCE_DIR}/CHANGELOG.md" "${debian}/changelogs.sh"
    VERBATIM)
  add_custom_target(debian_changelogs ALL DEPENDS "${changelogs}/changelog.Debian.gz")
endif()
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER "${component}" upper)
  set(documents share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  install(FILES "${debian}/copyright" DESTINATION ${documents} COMPONENT ${component})
  install(FILES "${changelogs}/changelog.Debian.gz" "${changelogs}/changelog.gz" DESTINATION ${documents} COMPONENT ${component} OPTIONAL)
endforeach()
install(FILES "${debian}/overrides" DESTINATION share/lintian/overrides RENAME binnacle COMPONENT runtime)

# ---- the source: cmake --build build/release --target dist

add_custom_target(dist
  COMMAND bash "${PROJECT_SOURCE_DIR}/sdk/dist/source" ${PROJECT_VERSION} "${PROJECT_BINARY_DIR}"
  USES_TERMINAL VERBATIM)

include(CPack)
