# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where, in components: `runtime` runs filters, `dev` builds plugins and programs,
# `python` is the Python package.
# The folders are fixed, not those of GNUInstallDirs: the command finds its plugins at ../lib/binnacle and its templates
# at ../share/binnacle/sdk/template, so that the whole may be moved. Below share/binnacle documents and configs lie as in
# the project, so that the links between them hold.
include_guard(GLOBAL)

include(CMakePackageConfigHelpers)

set(package_folder lib/cmake/Binnacle)

# ---- runtime: the command, the plugins, what `binnacle new plugin` copies

# binnacle_left_out(COMPONENT TARGET WHAT FILE…): sdk/run builds what a run needs. The rest is installed where it was built;
# where it was not, installing names each file, what it is for, and the target that builds it.
function(binnacle_left_out component target what)
  install(CODE "
    set(missing \"\")
    foreach(file IN ITEMS ${ARGN})
      if(NOT EXISTS \"\${file}\")
        get_filename_component(name \"\${file}\" NAME)
        list(APPEND missing \"\${name}\")
      endif()
    endforeach()
    list(LENGTH missing count)
    list(JOIN missing \", \" missing)
    if(count EQUAL 1)
      message(STATUS \"Left out, since it is not built: \${missing}, ${what} (cmake --build ${PROJECT_BINARY_DIR} --target ${target})\")
    elseif(count GREATER 1)
      message(STATUS \"Left out, since they are not built: \${missing}, ${what} (cmake --build ${PROJECT_BINARY_DIR} --target ${target})\")
    endif()" COMPONENT ${component})
endfunction()

install(TARGETS binnacle EXPORT BinnacleTargets RUNTIME DESTINATION bin COMPONENT runtime)
get_property(verb_modules GLOBAL PROPERTY BINNACLE_VERB_MODULES)
install(TARGETS ${verb_modules} RUNTIME DESTINATION bin COMPONENT runtime OPTIONAL)
list(TRANSFORM verb_modules REPLACE "(.+)" "$<TARGET_FILE:\\1>")
binnacle_left_out(runtime binnacle_verbs "for verbs of the command" ${verb_modules})

get_property(plugins GLOBAL PROPERTY BINNACLE_PLUGINS)
list(TRANSFORM plugins APPEND _plugin)
install(TARGETS ${plugins} LIBRARY DESTINATION lib/binnacle COMPONENT runtime OPTIONAL)
list(TRANSFORM plugins REPLACE "(.+)" "$<TARGET_FILE:\\1>")
binnacle_left_out(runtime binnacle_plugins "for configs with their types" ${plugins})

install(DIRECTORY "${PROJECT_SOURCE_DIR}/configs" DESTINATION ${BINNACLE_SHARE_FOLDER} COMPONENT runtime REGEX "/benchmarks/run$" EXCLUDE)
install(PROGRAMS "${PROJECT_SOURCE_DIR}/configs/benchmarks/run" DESTINATION ${BINNACLE_SHARE_FOLDER}/configs/benchmarks COMPONENT runtime)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/sdk/template" "${PROJECT_SOURCE_DIR}/sdk/examples" "${PROJECT_SOURCE_DIR}/sdk/docs"
  DESTINATION ${BINNACLE_SHARE_FOLDER}/sdk COMPONENT runtime PATTERN build EXCLUDE PATTERN __pycache__ EXCLUDE
  REGEX "/examples/.*/[.]gitignore$" EXCLUDE
  REGEX "[.](sh|sbatch)$" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

file(GLOB documents RELATIVE "${PROJECT_SOURCE_DIR}" CONFIGURE_DEPENDS
  LICENSE *.md CITATION.cff kernel/*.md sdk/packages.txt plugins/*/README.md)
foreach(document IN LISTS documents)
  cmake_path(GET document PARENT_PATH folder)
  install(FILES "${PROJECT_SOURCE_DIR}/${document}" DESTINATION ${BINNACLE_SHARE_FOLDER}/${folder} COMPONENT runtime)
endforeach()

# Made by the target reference_page, which sdk/run CONFIG does not build.
get_property(reference_page GLOBAL PROPERTY BINNACLE_REFERENCE_PAGE)
if(reference_page)
  install(CODE "
    if(EXISTS \"${reference_page}\")
      file(INSTALL \"${reference_page}\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${BINNACLE_SHARE_FOLDER}/sdk/docs\")
    else()
      message(STATUS \"Left out, since it is not built: the reference of all types and keys \"
        \"(cmake --build ${PROJECT_BINARY_DIR} --target reference_page)\")
    endif()" COMPONENT runtime)
endif()

# Made by the target help_pages.
get_property(help_folder GLOBAL PROPERTY BINNACLE_HELP_FOLDER)
if(help_folder)
  # A wildcard finds nothing where nothing was built.
  install(CODE "
    file(GLOB pages \"${help_folder}/man/*.1.gz\")
    if(pages)
      # Where zsh of Debian looks, for packages and for /usr/local.
      set(zsh site-functions)
      if(CMAKE_INSTALL_PREFIX MATCHES \"(^|/)usr$\")
        set(zsh vendor-completions)
      endif()
      file(INSTALL \${pages} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/share/man/man1\")
      file(INSTALL \"${help_folder}/bash/binnacle\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/share/bash-completion/completions\")
      file(INSTALL \"${help_folder}/zsh/_binnacle\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/share/zsh/\${zsh}\")
    else()
      message(STATUS \"Left out, since they are not built: manual pages and shell completion \"
        \"(cmake --build ${PROJECT_BINARY_DIR} --target help_pages)\")
    endif()" COMPONENT runtime)
endif()

# ---- doc: the manual as a site, where sdk/site/build made it before this is configured

if(EXISTS "${PROJECT_SOURCE_DIR}/build/site/index.html")
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/build/site/" DESTINATION share/doc/binnacle/html COMPONENT doc OPTIONAL
    PATTERN "sitemap.xml*" EXCLUDE)  # for search engines; the packed one has a time in it
endif()

# ---- mpi: studies on several machines, where there is an MPI

if(TARGET binnacle_mpi)
  install(TARGETS binnacle_mpi LIBRARY DESTINATION lib/binnacle/mpi COMPONENT mpi OPTIONAL)
  binnacle_left_out(mpi binnacle_mpi "for studies under mpirun" "$<TARGET_FILE:binnacle_mpi>")
endif()

# ---- dev: headers, the kernel's library, the CMake package

install(DIRECTORY "${PROJECT_SOURCE_DIR}/kernel/include/binnacle" "${PROJECT_BINARY_DIR}/kernel/include/binnacle"
  DESTINATION include COMPONENT dev FILES_MATCHING PATTERN "*.hpp")
# Where the documents look for them.
install(CODE "
  set(folder \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${BINNACLE_SHARE_FOLDER}/kernel\")
  file(MAKE_DIRECTORY \"\${folder}\")
  file(CREATE_LINK ../../../include \"\${folder}/include\" SYMBOLIC)" COMPONENT dev)

# Whoever writes plugins needs no Boost: the kernel's library is an export set of its own.
install(TARGETS binnacle_headers EXPORT BinnacleTargets INCLUDES DESTINATION include)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/sdk/score/include/score" "${PROJECT_SOURCE_DIR}/sdk/document/include/document"
  DESTINATION include COMPONENT dev FILES_MATCHING PATTERN "*.hpp")
# The suite's checkers, for a plugin's own tests.
install(DIRECTORY "${PROJECT_SOURCE_DIR}/sdk/testing/include/binnacle" DESTINATION include COMPONENT dev
  FILES_MATCHING PATTERN "*.hpp")
install(TARGETS binnacle_testing EXPORT BinnacleTestingTargets
  ARCHIVE DESTINATION lib COMPONENT dev OPTIONAL
  INCLUDES DESTINATION include)
binnacle_left_out(dev binnacle_testing "for a plugin's own tests" "$<TARGET_FILE:binnacle_testing>")
install(TARGETS binnacle_document EXPORT BinnacleDocumentTargets
  ARCHIVE DESTINATION lib COMPONENT dev OPTIONAL
  INCLUDES DESTINATION include)
binnacle_left_out(dev binnacle_document "for programs that describe components" "$<TARGET_FILE:binnacle_document>")
install(TARGETS binnacle_kernel binnacle_algebra binnacle_score binnacle_smooth EXPORT BinnacleKernelTargets
  ARCHIVE DESTINATION lib COMPONENT dev
  INCLUDES DESTINATION include)
# A program in C needs nothing else of Binnacle, so its library is an export set of its own too.
install(FILES "${PROJECT_SOURCE_DIR}/sdk/c/include/binnacle.h" DESTINATION include COMPONENT dev)
install(TARGETS binnacle_c EXPORT BinnacleCTargets
  LIBRARY DESTINATION lib COMPONENT runtime OPTIONAL NAMELINK_COMPONENT dev)
binnacle_left_out(runtime binnacle_c "for programs in C" "$<TARGET_FILE:binnacle_c>")
foreach(set IN ITEMS BinnacleTargets BinnacleTestingTargets BinnacleKernelTargets BinnacleDocumentTargets BinnacleCTargets)
  install(EXPORT ${set} NAMESPACE Binnacle:: DESTINATION ${package_folder} COMPONENT dev)
endforeach()

configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/BinnacleConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/package/BinnacleConfig.cmake"
  INSTALL_DESTINATION ${package_folder}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/package/BinnacleConfigVersion.cmake"
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(
  FILES
    "${PROJECT_BINARY_DIR}/package/BinnacleConfig.cmake"
    "${PROJECT_BINARY_DIR}/package/BinnacleConfigVersion.cmake"
    "${CMAKE_CURRENT_LIST_DIR}/BinnaclePlugin.cmake"
    "${CMAKE_CURRENT_LIST_DIR}/binnacle_plugin.map"
  DESTINATION ${package_folder} COMPONENT dev)

# ---- python: the package, which finds its plugins at ../../../binnacle

if(TARGET binnacle_python)
  set(python_folder lib/python3/dist-packages/binnacle)
  get_property(python_files GLOBAL PROPERTY BINNACLE_PYTHON_FILES)
  install(TARGETS binnacle_python LIBRARY DESTINATION ${python_folder} COMPONENT python OPTIONAL)
  # What is Python is of no use without what is C++.
  install(CODE "
    if(EXISTS \"$<TARGET_FILE:binnacle_python>\")
      file(INSTALL ${python_files} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${python_folder}\")
    else()
      message(STATUS \"Left out, since it is not built: the Python package \"
        \"(cmake --build ${PROJECT_BINARY_DIR} --target python)\")
    endif()" COMPONENT python)
endif()
