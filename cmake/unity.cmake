# Files of a layer compiled together, a dozen at a time: headers are read and templates made once for all of them, which
# takes half the processor time of the library's build from nothing and a quarter of the tests'. A change of one file
# compiles its whole dozen again, in less than a minute. tools/check_names.py keeps the layers fit for it: no two files of a
# layer may use the same name in their unnamed namespaces; each test has a namespace of its file's name. A unit hides what
# a file forgot to include: ./dev check compiles what has changed alone.
option(BRIM_UNITY "Compile files of a layer together" ON)
set(BRIM_UNITY_FILES 12)

# @param root  folder of the layers, below CMAKE_CURRENT_SOURCE_DIR
function(brim_unity target root)
  if(NOT BRIM_UNITY)
    return()
  endif()
  # A tenth of such a build went into collecting the compiler's own garbage, which up to 1.5 GB can lie.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1500000>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/${root} OUTPUT_VARIABLE inside)
    string(REGEX REPLACE "/.*" "" layer "${inside}")
    if(NOT DEFINED count_${layer})
      set(count_${layer} 0)
    endif()
    math(EXPR group "${count_${layer}} / ${BRIM_UNITY_FILES}")
    math(EXPR count_${layer} "${count_${layer}} + 1")
    set_property(SOURCE ${source} PROPERTY UNITY_GROUP ${layer}_${group})
  endforeach()
endfunction()
