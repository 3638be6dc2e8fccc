# Every third-party library; docs/dependencies.md says why each is there.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(assimp REQUIRED)
find_package(CLI11 REQUIRED)
