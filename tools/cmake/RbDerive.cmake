# rb_derive(target name description.toml): the equations of a description (common/multibody), for sources of `target`, as
#   #include "derived/<name>.hpp"
# Changing the description builds again.
function(rb_derive target name description)
  set(header ${CMAKE_CURRENT_BINARY_DIR}/derived/${name}.hpp)
  get_filename_component(description ${description} ABSOLUTE)
  file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/derived)
  add_custom_command(OUTPUT ${header} COMMAND rb-derive-model ${description} ${header}
    DEPENDS rb-derive-model ${description} COMMENT "Deriving the equations of ${name}" VERBATIM)
  target_sources(${target} PRIVATE ${header})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
endfunction()
