# One interface target that carries how brim's own code is compiled.
add_library(brim_options INTERFACE)
target_compile_options(brim_options INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  # Contraction of a*b+c would make results depend on the machine.
  -ffp-contract=off -fno-math-errno)
option(BRIM_WERROR "Take warnings for errors" OFF)
if(BRIM_WERROR)
  # What GCC finds by following values through optimised code is often wrong (bug 105651 of GCC 12 in std::string, for one):
  # it is shown, and no error; nor is what the macros of GoogleTest bring.
  target_compile_options(brim_options INTERFACE -Werror)
  foreach(kind restrict maybe-uninitialized array-bounds stringop-overflow stringop-overread stringop-truncation
      free-nonheap-object null-dereference dangling-pointer use-after-free nonnull dangling-else)
    target_compile_options(brim_options INTERFACE -Wno-error=${kind})
  endforeach()
endif()
# GCC 12 takes the copy within `"," + text()` of std::string for one that overlaps itself (GCC bug 105651, mended in 13). The
# files in which it says so are named where they are compiled; everywhere else the warning stays.
function(brim_false_restrict)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION MATCHES "^12\\.")
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -Wno-restrict)
  endif()
endfunction()
if(BRIM_NATIVE)
  target_compile_options(brim_options INTERFACE -march=native)
endif()
set(BRIM_SANITIZE "" CACHE STRING "Sanitizers to build with, for example address,undefined")
if(BRIM_SANITIZE)
  target_compile_options(brim_options INTERFACE -fsanitize=${BRIM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(brim_options INTERFACE -fsanitize=${BRIM_SANITIZE})
endif()
