# Every third-party library; docs/dependencies.md says why each is there.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(assimp REQUIRED)
find_package(ZLIB REQUIRED)
find_package(tinyxml2 REQUIRED)
find_package(CLI11 REQUIRED)

if(BRIM_TESTS)
  # The page's side of the viewer's server, in its tests. Debian ships cpp-httplib as a library without a CMake package.
  # The definitions must be those that the library was compiled with: they change the layout of its types.
  find_library(BRIM_HTTPLIB_LIBRARY cpp-httplib REQUIRED)
  find_path(BRIM_HTTPLIB_INCLUDE httplib.h REQUIRED)
  add_library(brim_httplib INTERFACE)
  target_include_directories(brim_httplib SYSTEM INTERFACE ${BRIM_HTTPLIB_INCLUDE})
  target_compile_definitions(brim_httplib INTERFACE CPPHTTPLIB_OPENSSL_SUPPORT CPPHTTPLIB_ZLIB_SUPPORT CPPHTTPLIB_BROTLI_SUPPORT)
  target_link_libraries(brim_httplib INTERFACE ${BRIM_HTTPLIB_LIBRARY})
endif()

# OpenVDB is optional: AUTO takes it when it is there. Debian ships it without a CMake package of its own.
set(BRIM_OPENVDB AUTO CACHE STRING "Read and write OpenVDB volumes: AUTO, ON or OFF")
set_property(CACHE BRIM_OPENVDB PROPERTY STRINGS AUTO ON OFF)
set(BRIM_HAS_OPENVDB OFF)
if(BRIM_OPENVDB)
  find_path(BRIM_OPENVDB_INCLUDE openvdb/openvdb.h)
  find_path(BRIM_BOOST_INCLUDE boost/numeric/conversion/conversion_traits.hpp)  # its headers ask for it
  find_library(BRIM_OPENVDB_LIBRARY openvdb)
  find_library(BRIM_IMATH_LIBRARY NAMES Imath-3_1 Imath)
  if(BRIM_OPENVDB_INCLUDE AND BRIM_BOOST_INCLUDE AND BRIM_OPENVDB_LIBRARY AND BRIM_IMATH_LIBRARY)
    set(BRIM_HAS_OPENVDB ON)
  elseif(NOT BRIM_OPENVDB STREQUAL "AUTO")
    message(FATAL_ERROR "BRIM_OPENVDB is ${BRIM_OPENVDB}, but OpenVDB is not here (Debian: libopenvdb-dev libboost-dev)")
  endif()
endif()
