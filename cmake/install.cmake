# Installs the library, its headers and the program; a project then says find_package(brim) and links brim::brim.
include(CMakePackageConfigHelpers)

set(BRIM_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/brim)

install(TARGETS brim brim_plugin EXPORT brimTargets)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/brim DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(EXPORT brimTargets NAMESPACE brim:: DESTINATION ${BRIM_CONFIG_DIR})
if(TARGET brim_cli)
  install(TARGETS brim_cli)
  # A shared library is found beside the program, wherever both were moved.
  file(RELATIVE_PATH to_lib ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(brim_cli PROPERTIES INSTALL_RPATH "$ORIGIN/${to_lib}")
endif()

# A static library passes its private dependencies on to whoever links it; a shared one does not.
get_target_property(BRIM_LIBRARY_TYPE brim TYPE)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/brimConfig.cmake.in ${PROJECT_BINARY_DIR}/brimConfig.cmake
  INSTALL_DESTINATION ${BRIM_CONFIG_DIR})
# Before 1.0 any minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/brimConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/brimConfig.cmake ${PROJECT_BINARY_DIR}/brimConfigVersion.cmake
  DESTINATION ${BRIM_CONFIG_DIR})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/THIRD_PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR} OPTIONAL)
# Notices of what is compiled in, as Debian has them (THIRD_PARTY.md holds that of the page's three.js).
foreach(package libeigen3-dev nlohmann-json3-dev libcli11-dev pybind11-dev libfmt-dev)
  install(FILES /usr/share/doc/${package}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR}/third_party RENAME ${package} OPTIONAL)
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/described.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/package.cmake)

# What people start from. Scenes name the schema as ../schema/scene.schema.json.
set(BRIM_SHARE ${CMAKE_INSTALL_DATADIR}/brim)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/schema ${PROJECT_SOURCE_DIR}/scenes DESTINATION ${BRIM_SHARE} FILES_MATCHING PATTERN "*.json"
  PATTERN "*.urdf" PATTERN "*.obj")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${BRIM_SHARE} FILES_MATCHING PATTERN "*.cpp" PATTERN "*.py"
  PATTERN "*.json" PATTERN "*/*/CMakeLists.txt")

# The viewer's page, when it has been built, and the script that makes pictures with it.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/viewer/dist/ DESTINATION ${CMAKE_INSTALL_DATADIR}/brim/viewer OPTIONAL)
install(FILES ${PROJECT_SOURCE_DIR}/viewer/render.mjs DESTINATION ${CMAKE_INSTALL_DATADIR}/brim/viewer)

# What draws the diagrams of brim plot.
install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/plot_run.py DESTINATION ${CMAKE_INSTALL_DATADIR}/brim)

# For pkg-config. A static library needs what it stands on said as well.
set(brim_pc_requires "eigen3, fmt")
set(brim_pc_libs "")
if(BRIM_LIBRARY_TYPE STREQUAL "STATIC_LIBRARY")
  string(APPEND brim_pc_requires ", assimp, zlib, tinyxml2, hdf5")
  if(BRIM_HAS_OPENVDB)
    string(APPEND brim_pc_libs " ${BRIM_OPENVDB_LIBRARY} ${BRIM_IMATH_LIBRARY} ${BRIM_TBB_LIBRARY}")
  endif()
  if(BRIM_HAS_GDCM)
    string(REPLACE ";" " " gdcm "${BRIM_GDCM_LIBRARIES}")
    string(APPEND brim_pc_libs " ${gdcm}")
  endif()
endif()
file(RELATIVE_PATH brim_pc_up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${CMAKE_CURRENT_LIST_DIR}/brim.pc.in ${PROJECT_BINARY_DIR}/brim.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/brim.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
