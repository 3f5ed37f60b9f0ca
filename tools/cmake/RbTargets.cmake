# The four kinds of target of this project.  Each carries its own requirements.

include(RbEmbed)
include(RbDerive)

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

find_program(RB_CCACHE ccache)
if(RB_CCACHE)
  # Paths below the source tree are looked up as relative ones, so that another clone finds what this one compiled.
  # Precompiled headers are compared by what they hold.
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_SLOPPINESS=pch_defines,time_macros ${RB_CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CMAKE_CXX_COMPILER_LAUNCHER})
  # Debug information names the folder it was compiled in, which must be the same in every clone, too.
  add_compile_options($<$<CONFIG:Debug>:-fdebug-prefix-map=${CMAKE_SOURCE_DIR}=.>)
endif()

set(RB_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined")

# Requirements of every target of ours: language, warnings, include root, sanitizers.
add_library(rb_options INTERFACE)
target_compile_features(rb_options INTERFACE cxx_std_20)
target_include_directories(rb_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(rb_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror)
# In loops g++ 12 goes on with a vector that it has read although one that overlaps it was stored since: sums of Eigen's
# segments come out wrong (host/analysis/identify/test/instruments_test.cpp).
target_compile_options(rb_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fno-predictive-commoning>)
# For sources in which g++ 12 takes a sum of texts for writing out of bounds (its bug 105651).
set(RB_SUMS_OF_TEXTS "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
if(RB_SANITIZE)
  # LCM's C++ header casts through unrelated types, which the vptr check refuses.  With its checks between them g++
  # 12 takes the members of std::stop_source for uninitialised, and sums of texts for writing out of bounds.
  target_compile_options(rb_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized> ${RB_SUMS_OF_TEXTS}
    -fsanitize=${RB_SANITIZE} -fno-sanitize=vptr -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(rb_options INTERFACE -fsanitize=${RB_SANITIZE})
endif()

# The sanitizers' options in the tests' environment.
set(RB_SANITIZER_ENVIRONMENT "TSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tools/cmake/tsan.supp"
  "LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tools/cmake/lsan.supp:print_suppressions=0")
# ASan keeps what was freed, up to so much, to notice who still uses it; where a test weighs memory that would be growth.
set(RB_WEIGHED_ENVIRONMENT "ASAN_OPTIONS=quarantine_size_mb=1:thread_local_quarantine_size_kb=64")

# _rb_batches(target headers): how it is compiled.
function(_rb_batches target headers)
  if(RB_BATCHES)
    target_precompile_headers(${target} REUSE_FROM ${headers})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
  endif()
endfunction()

# rb_apart(source...): sources of this directory that are never compiled together with others.
function(rb_apart)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# rb_library(name source... [DEPENDS target...])
function(rb_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS")
  add_library(${name} STATIC ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PUBLIC rb_options ${arg_DEPENDS})
  _rb_batches(${name} rb_headers)
endfunction()

# rb_program(name source... [PACKAGE component] [DEPENDS target...]): PACKAGE for what users call, in which package it
# comes to them; its manual pages and completion (common/command_line/manual.hpp) lie in manual/ of the build folder.
function(rb_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PACKAGE" "DEPENDS")
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE rb_options ${arg_DEPENDS})
  _rb_batches(${name} rb_headers)
  if(arg_PACKAGE)
    set(manual ${CMAKE_BINARY_DIR}/manual/${name})
    target_link_libraries(${name} PRIVATE rb_command_line)
    add_custom_command(TARGET ${name} POST_BUILD COMMAND ${name} --write-manual ${manual} VERBATIM)
    install(TARGETS ${name} DESTINATION bin COMPONENT ${arg_PACKAGE})
    install(DIRECTORY ${manual}/ DESTINATION share/man/man1 COMPONENT ${arg_PACKAGE} FILES_MATCHING PATTERN *.1)
    install(FILES ${manual}/${name}.bash DESTINATION share/bash-completion/completions COMPONENT ${arg_PACKAGE}
      RENAME ${name})
  endif()
endfunction()

# rb_unit(file component): a unit of systemd, something to add to one (in UNIT.d), or a rule of udev, that comes with a
# package.
function(rb_unit file component)
  set(place lib/systemd/system)
  if(file MATCHES "\\.rules$")
    set(place lib/udev/rules.d)
  endif()
  cmake_path(GET file PARENT_PATH folder)
  if(folder MATCHES "([^/]+\\.d)$")
    string(APPEND place /${CMAKE_MATCH_1})
  endif()
  install(FILES ${file} DESTINATION ${place} COMPONENT ${component})
endfunction()

# rb_tests(name... [PROGRAM program] [DEPENDS target...] [PROGRAMS target...]): each test/<name>.cpp is one CTest.  All of a directory are one
# program, <directory>_tests, which runs the files it is given (common/test/main.cpp), but those that name another of their own.  PROGRAMS
# are what the tests start from $RB_BIN, which their label `programs` shows.
# With BUILD_TESTING off (tools/demo on a bare machine) there are no tests.
function(rb_tests)
  if(NOT BUILD_TESTING)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "PROGRAM" "DEPENDS;PROGRAMS")
  rb_test_program(program)
  foreach(name IN LISTS arg_UNPARSED_ARGUMENTS)
    target_sources(${program} PRIVATE test/${name}.cpp)
    rb_files_of_test(rb_test_files ${name})
    add_test(NAME ${name} COMMAND ${program} ${rb_test_files})
    rb_test_properties(${name})
  endforeach()
endfunction()

# rb_lanes_tests(name... [PROGRAM program] [DEPENDS target...]): rb_tests of kernels that the processor chooses by their width
# (common/dsp/lanes.hpp), and the same once more for each narrower one that x86-64 machines may run.
function(rb_lanes_tests)
  rb_tests(${ARGN})
  if(NOT BUILD_TESTING OR NOT CMAKE_SYSTEM_PROCESSOR STREQUAL x86_64)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "PROGRAM" "DEPENDS")
  rb_test_program(program)
  foreach(name IN LISTS arg_UNPARSED_ARGUMENTS)
    rb_files_of_test(rb_test_files ${name})
    foreach(lanes 2 4)
      add_test(NAME ${name}_lanes_${lanes} COMMAND ${program} ${rb_test_files})
      rb_test_properties(${name}_lanes_${lanes})
      set_property(TEST ${name}_lanes_${lanes} APPEND PROPERTY ENVIRONMENT RB_MOST_LANES=${lanes})
    endforeach()
  endforeach()
endfunction()

# rb_guest_tests(name... [RT] [DEPENDS target...] [PROGRAMS target...] [FILES path...]): the same for tests that need the
# guest machine's kernel, and FILES beside its programs.  They are of the test configuration `guest`, so that a plain
# ctest leaves them out; hil_tests/run boots the guest and runs there those with the label guest or, with RT, guest-rt.
function(rb_guest_tests)
  if(NOT BUILD_TESTING)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 0 arg "RT;SLEEP" "" "DEPENDS;PROGRAMS;FILES")
  rb_test_program(program)
  # hil_tests/run reads REQUIRED_FILES, to have them in the guest's memory before time matters.
  list(TRANSFORM arg_PROGRAMS REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE files)
  set(label guest)
  if(arg_RT)
    set(label guest-rt)
  elseif(arg_SLEEP)
    set(label guest-sleep)
  endif()
  foreach(name IN LISTS arg_UNPARSED_ARGUMENTS)
    target_sources(${program} PRIVATE test/${name}.cpp)
    add_test(NAME ${name} CONFIGURATIONS guest COMMAND ${program} ${name}.cpp)
    rb_test_properties(${name})
    set_tests_properties(${name} PROPERTIES LABELS ${label} REQUIRED_FILES "${files};${arg_FILES}")
  endforeach()
endfunction()

# The program of this directory's tests, with the caller's DEPENDS and PROGRAMS.
macro(rb_test_program variable)
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE ${variable})
  string(REPLACE "/" "_" ${variable} ${${variable}}_tests)
  if(arg_PROGRAM)
    set(${variable} ${arg_PROGRAM})
  endif()
  if(NOT TARGET ${${variable}})
    add_executable(${${variable}} ${CMAKE_SOURCE_DIR}/common/test/main.cpp)
    target_link_libraries(${${variable}} PRIVATE rb_options GTest::gtest)
    if(RB_BATCHES)
      target_precompile_headers(${${variable}} REUSE_FROM rb_test_headers)
    endif()
  endif()
  target_link_libraries(${${variable}} PRIVATE ${arg_DEPENDS})
  if(arg_PROGRAMS)
    add_dependencies(${${variable}} ${arg_PROGRAMS})
  endif()
endmacro()

# Such a program runs one test by the name of its file; a program of the caller's own runs whole.
macro(rb_files_of_test variable name)
  set(${variable} ${name}.cpp)
  if(arg_PROGRAM)
    set(${variable})
  endif()
endmacro()

macro(rb_test_properties name)
  # For what hangs: a slow machine with much else to do must not come near it, nor an emulator.
  set(rb_timeout 900)
  if(CMAKE_CROSSCOMPILING)
    set(rb_timeout 3600)
  endif()
  if(arg_PROGRAMS)
    set_tests_properties(${name} PROPERTIES LABELS programs)
  endif()
  # The bus of the car that this computer may be of is nothing for a test.
  set_tests_properties(${name} PROPERTIES TIMEOUT ${rb_timeout}
    ENVIRONMENT "LCM_DEFAULT_URL=;RB_BIN=${CMAKE_BINARY_DIR}/bin;RB_SOURCE=${CMAKE_SOURCE_DIR};${RB_SANITIZER_ENVIRONMENT}")
endmacro()
