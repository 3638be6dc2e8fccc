# Eigen and fmt cost most of a file's compilation: a target's headers are read once and kept. Compiler caches look at
# whole texts instead, so that with a compiler launcher every file is compiled on its own, which also shows any include
# that a file forgot.
set(BRIM_PRECOMPILE_DEFAULT ON)
if(CMAKE_CXX_COMPILER_LAUNCHER)
  set(BRIM_PRECOMPILE_DEFAULT OFF)
endif()
option(BRIM_PRECOMPILE "Read common headers once per target" ${BRIM_PRECOMPILE_DEFAULT})

function(brim_precompile target)
  if(NOT BRIM_PRECOMPILE)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <Eigen/Cholesky> <Eigen/Eigenvalues>
    <fmt/format.h> <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <numbers> <span> <string> <vector>
    ${ARGN})
endfunction()
