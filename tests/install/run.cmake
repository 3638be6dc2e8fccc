# cmake -D build=<brim's build folder> -D source=<this folder> -D example=<examples/user_body> -D work=<scratch> -D compiler=<c++> -P run.cmake
# Installs brim into an empty prefix, then configures, builds and runs the consumer against it alone.
file(REMOVE_RECURSE ${work})
set(prefix ${work}/prefix)

function(must)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed with ${result}: ${command}")
  endif()
endfunction()

must(${CMAKE_COMMAND} --install ${build} --prefix ${prefix})
# The package must work from wherever it is moved to.
file(RENAME ${prefix} ${work}/moved)
must(${CMAKE_COMMAND} -G Ninja -S ${source} -B ${work}/build -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_PREFIX_PATH=${work}/moved)
must(${CMAKE_COMMAND} --build ${work}/build)
must(${work}/build/consumer)
must(${work}/build/everything)

# The example of a body of one's own: a plugin for the installed program.
must(${CMAKE_COMMAND} -G Ninja -S ${example} -B ${work}/example -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_PREFIX_PATH=${work}/moved)
must(${CMAKE_COMMAND} --build ${work}/example)
must(${work}/moved/bin/brim --plugin ${work}/example/jelly.so run ${example}/jelly.json --frames 2 --quiet -o ${work}/run)
