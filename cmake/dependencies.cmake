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

# Debian ships cpp-httplib as a library without a CMake package. The definitions must be those that the library was
# compiled with: they change the layout of its types.
find_library(BRIM_HTTPLIB_LIBRARY cpp-httplib REQUIRED)
find_path(BRIM_HTTPLIB_INCLUDE httplib.h REQUIRED)
add_library(brim_httplib INTERFACE)
target_include_directories(brim_httplib SYSTEM INTERFACE ${BRIM_HTTPLIB_INCLUDE})
target_compile_definitions(brim_httplib INTERFACE CPPHTTPLIB_OPENSSL_SUPPORT CPPHTTPLIB_ZLIB_SUPPORT CPPHTTPLIB_BROTLI_SUPPORT)
target_link_libraries(brim_httplib INTERFACE ${BRIM_HTTPLIB_LIBRARY})
