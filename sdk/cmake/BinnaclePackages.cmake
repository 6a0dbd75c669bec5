# SPDX-License-Identifier: Apache-2.0
# Debian packages, made by `cpack -G DEB` in the build folder: binnacle (component runtime), binnacle-dev (dev); where there
# is an MPI, binnacle-mpi (mpi); where the Python package is built, python3-binnacle (python).
include_guard(GLOBAL)

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_PACKAGE_VENDOR "Binnacle")
set(CPACK_PACKAGE_CONTACT "The Binnacle maintainers <maintainers@binnacle.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

# CPack puts the project's own line above these.
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "The command binnacle, which runs and checks filters, its plugins and its guides.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME binnacle)
# Loaded by name, so that shlibdeps, which adds to this, does not see it.
get_property(netcdf_package GLOBAL PROPERTY BINNACLE_NETCDF_PACKAGE)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "${netcdf_package}")

set(CPACK_DEBIAN_DEV_DESCRIPTION
  "Headers, library and CMake package: for plugins, and for programs that embed a filter.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME binnacle-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "binnacle (= ${PROJECT_VERSION}), libeigen3-dev")
# Only an embedding program needs these.
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "nlohmann-json3-dev, libboost-dev, libboost-filesystem-dev")

if(TARGET binnacle_mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
  set(CPACK_DEBIAN_MPI_DESCRIPTION "What `binnacle study` needs under mpirun.")
  set(CPACK_DEBIAN_MPI_PACKAGE_NAME binnacle-mpi)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "binnacle (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_MPI_PACKAGE_RECOMMENDS "openmpi-bin")
endif()

if(TARGET binnacle_python)
  get_property(python_version GLOBAL PROPERTY BINNACLE_PYTHON_VERSION)
  list(APPEND CPACK_COMPONENTS_ALL python)
  string(REGEX MATCH "[0-9]+$" minor "${python_version}")
  math(EXPR minor "${minor} + 1")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "The same filters in Python: runs, sessions and results as numpy arrays.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-binnacle)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # The module is of one version of Python.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "binnacle (= ${PROJECT_VERSION}), python3 (>= ${python_version}), python3 (<< 3.${minor}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-pandas, python3-xarray, python3-matplotlib")
  # Byte code is made when it is installed, and leaves with it.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${CMAKE_CURRENT_LIST_DIR}/debian/postinst" "${CMAKE_CURRENT_LIST_DIR}/debian/prerm")
endif()

include(CPack)
