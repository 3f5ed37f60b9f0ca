# rb_embed(target name file): the text of `file`, for sources of `target`, as
#   #include "embedded/<name>.hpp"   ->   roadbalance::embedded::k<Name>, a std::string_view
# with <name> in snake_case and <Name> in CamelCase.  Changing the file builds again.
function(rb_embed target name file)
  string(REPLACE "_" ";" words ${name})
  set(symbol k)
  foreach(word IN LISTS words)
    string(SUBSTRING ${word} 0 1 first)
    string(SUBSTRING ${word} 1 -1 rest)
    string(TOUPPER ${first} first)
    string(APPEND symbol ${first}${rest})
  endforeach()

  file(READ ${file} text)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/embedded/${name}.hpp @ONLY CONTENT
"#pragma once
#include <string_view>

namespace roadbalance::embedded {
inline constexpr std::string_view @symbol@ = R\"embedded(@text@)embedded\";
}  // namespace roadbalance::embedded
")
  target_include_directories(${target} SYSTEM PUBLIC ${CMAKE_BINARY_DIR}/generated)
endfunction()
