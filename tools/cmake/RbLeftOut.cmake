# Parts that this build leaves out, because something is not installed or not wanted.  The configuration counts and names
# them at its end; tools/check reads them from left_out.txt of the build folder.

# Options follow what is installed now: CMake looks again for what it did not find before, and by this also for a program,
# library or header that it found and that is gone.
get_cmake_property(rb_cached CACHE_VARIABLES)
foreach(variable IN LISTS rb_cached)
  get_property(type CACHE ${variable} PROPERTY TYPE)
  get_property(help CACHE ${variable} PROPERTY HELPSTRING)
  if(NOT variable MATCHES "^CMAKE_" AND (type STREQUAL FILEPATH OR help STREQUAL "Path to a file."))
    if(IS_ABSOLUTE "${${variable}}" AND NOT EXISTS "${${variable}}")
      unset(${variable} CACHE)
    endif()
  endif()
endforeach()

# rb_left_out(what why)
function(rb_left_out what why)
  set_property(GLOBAL APPEND PROPERTY RB_LEFT_OUT "${what}: ${why}")
endfunction()

function(rb_tell_left_out)
  get_property(parts GLOBAL PROPERTY RB_LEFT_OUT)
  list(LENGTH parts number)
  list(JOIN parts "\n" lines)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/left_out.txt CONTENT "${lines}\n" @ONLY)
  message(STATUS "Left out: ${number}")
  foreach(part IN LISTS parts)
    message(STATUS "  ${part}")
  endforeach()
endfunction()
