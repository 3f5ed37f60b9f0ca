# Everything we take from elsewhere, each behind one imported target.

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
if(BUILD_TESTING)
  find_package(GTest REQUIRED)
  find_package(benchmark REQUIRED)
endif()
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)

# LCM and FFTW ship no usable CMake package in Debian; lcm.pc asks for GLib headers nobody needs.
function(rb_find_library target header library)
  find_path(${target}_INCLUDE ${header} REQUIRED)
  find_library(${target}_LIBRARY ${library} REQUIRED)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} SYSTEM INTERFACE ${${target}_INCLUDE})
  target_link_libraries(${target} INTERFACE ${${target}_LIBRARY})
endfunction()
rb_find_library(lcm lcm/lcm-cpp.hpp lcm)
rb_find_library(gpiod gpiod.h gpiod)
option(RB_WITH_FFTW "Transform with FFTW; without it Eigen's transform serves" ON)
if(RB_WITH_FFTW)
  rb_find_library(fftw fftw3.h fftw3)
endif()
find_path(TOMLPP_INCLUDE toml++/toml.h REQUIRED)
find_program(LCM_GEN lcm-gen REQUIRED)

# rb_lcm_types(target file.lcm...): C++ headers wire/<name>.hpp generated from the message files.
function(rb_lcm_types target)
  set(out ${CMAKE_BINARY_DIR}/generated)
  foreach(file IN LISTS ARGN)
    get_filename_component(name ${file} NAME_WE)
    add_custom_command(OUTPUT ${out}/wire/${name}.hpp
      COMMAND ${LCM_GEN} --cpp --cpp-hpath ${out} ${CMAKE_CURRENT_SOURCE_DIR}/${file}
      DEPENDS ${file} VERBATIM)
    list(APPEND headers ${out}/wire/${name}.hpp)
  endforeach()
  add_custom_target(${target}_generate DEPENDS ${headers})
  add_library(${target} INTERFACE)
  add_dependencies(${target} ${target}_generate)
  target_include_directories(${target} SYSTEM INTERFACE ${out})
  target_link_libraries(${target} INTERFACE lcm)
endfunction()
