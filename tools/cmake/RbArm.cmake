# Programs for a bare Cortex-M7, beside the host's: the same sources, compiled once more by Debian's cross compiler.
# Without it nothing is built, and the tests report that they are skipped.

find_program(RB_ARM_CXX arm-none-eabi-g++)
find_program(RB_ARM_AR arm-none-eabi-ar)
find_program(RB_PYTHON python3 REQUIRED)

set(RB_ARM_FLAGS -mthumb -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -specs=nano.specs)
# The compiler comes without its C++ library; asked for a file it does not have, it answers with the bare name.
set(RB_ARM_READY FALSE)
if(RB_ARM_CXX AND RB_ARM_AR)
  execute_process(COMMAND ${RB_ARM_CXX} ${RB_ARM_FLAGS} -print-file-name=libstdc++_nano.a
    OUTPUT_VARIABLE rb_arm_library OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(IS_ABSOLUTE "${rb_arm_library}")
    set(RB_ARM_READY TRUE)
  endif()
endif()
if(NOT RB_ARM_READY)
  rb_left_out("programs of the board's processor" "Debian's arm-none-eabi compiler or its C++ library is not installed (tools/setup check)")
endif()

set(RB_ARM_CXX_FLAGS ${RB_ARM_FLAGS} -std=c++20 -O2 -ffunction-sections -fdata-sections -fno-exceptions -fno-rtti
  -fno-threadsafe-statics -fno-use-cxa-atexit -I${CMAKE_SOURCE_DIR}
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wnon-virtual-dtor -Wno-register -Werror)

# _rb_arm_objects(variable name source...): the objects of a target, compiled as the sources or their headers change.
function(_rb_arm_objects variable name)
  set(objects)
  foreach(source IN LISTS ARGN)
    get_filename_component(path ${source} ABSOLUTE)
    get_filename_component(base ${source} NAME_WE)
    set(object ${CMAKE_CURRENT_BINARY_DIR}/${name}.dir/${base}.o)
    add_custom_command(OUTPUT ${object}
      COMMAND ${RB_CCACHE} ${RB_ARM_CXX} ${RB_ARM_CXX_FLAGS} -MD -MF ${object}.d -c ${path} -o ${object}
      DEPENDS ${path} DEPFILE ${object}.d COMMENT "Building ARM object ${name}/${base}.o" VERBATIM)
    list(APPEND objects ${object})
  endforeach()
  file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/${name}.dir)
  set(${variable} ${objects} PARENT_SCOPE)
endfunction()

# rb_arm_library(name source...): lib<name>.a
function(rb_arm_library name)
  if(NOT RB_ARM_READY)
    return()
  endif()
  _rb_arm_objects(objects ${name} ${ARGN})
  set(archive ${CMAKE_CURRENT_BINARY_DIR}/lib${name}.a)
  add_custom_command(OUTPUT ${archive} COMMAND ${RB_ARM_AR} crsD ${archive} ${objects} DEPENDS ${objects}
    COMMENT "Linking ARM library lib${name}.a" VERBATIM)
endfunction()

# rb_arm_program(name source... SCRIPT link-script [LIBRARIES rb_arm_library...]): ${CMAKE_BINARY_DIR}/bin/<name>.elf
function(rb_arm_program name)
  if(NOT RB_ARM_READY)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "SCRIPT" "LIBRARIES")
  _rb_arm_objects(objects ${name} ${arg_UNPARSED_ARGUMENTS})
  list(TRANSFORM arg_LIBRARIES REPLACE "(.+)" "${CMAKE_CURRENT_BINARY_DIR}/lib\\1.a")
  get_filename_component(script ${arg_SCRIPT} ABSOLUTE)
  set(elf ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/${name}.elf)
  add_custom_command(OUTPUT ${elf}
    COMMAND ${RB_ARM_CXX} ${RB_ARM_FLAGS} -nostartfiles -T ${script} -Wl,--gc-sections -Wl,--fatal-warnings
      -Wl,--no-warn-rwx-segments ${objects} ${arg_LIBRARIES} -lm -o ${elf}
    DEPENDS ${objects} ${arg_LIBRARIES} ${script} COMMENT "Linking ARM program ${name}.elf" VERBATIM)
  add_custom_target(${name}_elf ALL DEPENDS ${elf})
endfunction()

# rb_arm_test(name script argument...): a CTest that runs a script of Python; exit code 77 is a skip.
function(rb_arm_test name script)
  add_test(NAME ${name} COMMAND ${RB_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/${script} ${ARGN})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 900)
endfunction()
