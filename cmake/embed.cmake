# brim_embed(<target> <file> <function>): compiles a text file into the target as
#   const std::string& brim::<function>()
function(brim_embed target file function)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} text)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/embedded/${function}.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT "// Made from a text file by cmake/embed.cmake.
#include <string>

namespace brim {
const std::string& @function@();
const std::string& @function@() {
  static const std::string text = R\"EMBEDDED(@text@)EMBEDDED\";
  return text;
}
}  // namespace brim
")
  target_sources(${target} PRIVATE ${source})
endfunction()
