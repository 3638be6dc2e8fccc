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
must(${CMAKE_COMMAND} -G Ninja -S ${source} -B ${work}/build -D PKG_CONFIG_USE_CMAKE_PREFIX_PATH=ON -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_PREFIX_PATH=${work}/moved)
must(${CMAKE_COMMAND} --build ${work}/build)
must(${work}/build/consumer)
must(${work}/build/everything)
if(EXISTS ${work}/build/by_pkg_config)
  must(${work}/build/by_pkg_config)
endif()

# What people are given besides: examples, scenes, the schema they name, notices, words for shells and man.
foreach(file share/brim/schema/scene.schema.json share/brim/scenes/drape.json share/brim/examples/cpp_project/main.cpp
    share/doc/brim/THIRD_PARTY.md share/bash-completion/completions/brim share/man/man1/brim.1 share/man/man1/brim-run.1)
  if(NOT EXISTS ${work}/moved/${file})
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()
must(${work}/moved/bin/brim run ${work}/moved/share/brim/scenes/bounce.json --frames 2 --quiet -o ${work}/bounce)

# The example of a program of one's own steps a world and reads its contacts.
must(${CMAKE_COMMAND} -G Ninja -S ${work}/moved/share/brim/examples/cpp_project -B ${work}/drop -D CMAKE_CXX_COMPILER=${compiler}
  -D CMAKE_PREFIX_PATH=${work}/moved)
must(${CMAKE_COMMAND} --build ${work}/drop)
must(${work}/drop/drop)

# The example of a body of one's own: a plugin for the installed program.
must(${CMAKE_COMMAND} -G Ninja -S ${example} -B ${work}/example -D CMAKE_CXX_COMPILER=${compiler}
  -D CMAKE_PREFIX_PATH=${work}/moved)
file(STRINGS ${work}/example/CMakeCache.txt type REGEX "^CMAKE_BUILD_TYPE")
file(STRINGS ${work}/example/build.ninja optimised REGEX "FLAGS = .*-O[23]")
if(NOT optimised)
  message(FATAL_ERROR "a plugin that names no type of build is not optimised: ${type}")
endif()
must(${CMAKE_COMMAND} --build ${work}/example)
must(${work}/moved/bin/brim --plugin ${work}/example/jelly.so run ${example}/jelly.json --frames 2 --quiet -o ${work}/run)
