# cmake -D source=<checkout> -D header=<file> -D git=<git> -P commit.cmake
# Writes the commit of the checkout to a header, touching it only where it changed; nothing where there is no git.
set(commit "")
if(git)
  execute_process(COMMAND ${git} -C ${source} rev-parse --short=12 HEAD OUTPUT_VARIABLE commit ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  execute_process(COMMAND ${git} -C ${source} diff-index --quiet HEAD -- src apps schema RESULT_VARIABLE changed ERROR_QUIET
    OUTPUT_QUIET)
  if(commit AND changed EQUAL 1)
    string(APPEND commit ", changed")
  endif()
endif()
set(text "#pragma once\n#define BRIM_COMMIT \"${commit}\"\n")
set(old "")
if(EXISTS ${header})
  file(READ ${header} old)
endif()
if(NOT text STREQUAL old)
  file(WRITE ${header} "${text}")
endif()
