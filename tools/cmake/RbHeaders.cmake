# The headers that most sources include are compiled once: the standard library, Eigen and JSON (rb_headers.hpp), for
# tests GoogleTest, too.  Sources of one library are compiled together, a batch at a time.  RB_BATCHES=OFF compiles each
# by itself and without precompiled headers, which shows what a source forgets to include; a change of one then compiles
# only that.
option(RB_BATCHES "Compile sources in batches and with precompiled headers" ON)
if(RB_BATCHES)
  # Without it ccache cannot see what a precompiled header holds.
  target_compile_options(rb_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  # The headers alone fill the heap at which g++ begins to collect garbage; it then walks all of it again and again.
  target_compile_options(rb_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>)
  foreach(headers rb_headers rb_test_headers)
    if(headers STREQUAL rb_headers OR BUILD_TESTING)
      file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/${headers}.cpp CONTENT "")
      add_library(${headers} STATIC ${CMAKE_BINARY_DIR}/generated/${headers}.cpp)
      target_link_libraries(${headers} PRIVATE rb_options Eigen3::Eigen nlohmann_json::nlohmann_json)
      target_precompile_headers(${headers} PRIVATE ${CMAKE_CURRENT_LIST_DIR}/${headers}.hpp)
    endif()
  endforeach()
  if(BUILD_TESTING)
    target_link_libraries(rb_test_headers PRIVATE GTest::gtest GTest::gmock)
  endif()
endif()
