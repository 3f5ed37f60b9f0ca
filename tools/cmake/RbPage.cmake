# The page of a program, built by npm: TypeScript checked by tsc, bundled by esbuild.  Packages come from the registry
# that npm is configured for, once per package-lock.json; after that the build needs no network.

find_program(RB_NODE node REQUIRED)
find_program(RB_NPM npm REQUIRED)

# rb_page(target SOURCES file... WIRE file... ASSETS "path|file|type"...): an object library that defines
# roadbalance::page_assets() (host/web/web_server.hpp).  SOURCES lie beside package.json, with build.mjs, which makes the
# files of ASSETS in dist/; WIRE is what src/wire.ts is made of (wire_types.mjs).
function(rb_page target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;WIRE;ASSETS")
  set(from ${CMAKE_CURRENT_SOURCE_DIR})
  set(page ${CMAKE_CURRENT_BINARY_DIR}/npm)

  # Tests drive a browser, which the program does without.
  set(omit --omit=dev)
  if(BUILD_TESTING)
    set(omit --include=dev)
  endif()
  set(packages ${page}/node_modules/.package-lock.json)
  set(manifests package.json package-lock.json .npmrc)
  list(TRANSFORM manifests PREPEND ${from}/)
  add_custom_command(OUTPUT ${packages}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${page}
    COMMAND ${CMAKE_COMMAND} -E copy ${manifests} ${page}
    COMMAND ${CMAKE_COMMAND} -E chdir ${page} ${RB_NPM} ci ${omit} --ignore-scripts --prefer-offline --no-audit --no-fund
      --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${packages}
    DEPENDS ${manifests} COMMENT "Fetching the packages of ${target}" VERBATIM)

  string(REGEX REPLACE ":[^;]*" "" wire_files "${arg_WIRE}")
  set(files)
  set(assembly)
  set(entries)
  set(number 0)
  foreach(asset IN LISTS arg_ASSETS)
    string(REPLACE "|" ";" asset "${asset}")
    list(GET asset 0 path)
    list(GET asset 1 file)
    list(GET asset 2 type)
    list(APPEND files ${page}/dist/${file})
    string(APPEND assembly "asm(\".section .rodata\\n.global rb_asset_${number}, rb_asset_${number}_end\\n\"\n"
      "    \"rb_asset_${number}: .incbin \\\"${page}/dist/${file}\\\"\\nrb_asset_${number}_end: .byte 0\\n.previous\");\n"
      "extern \"C\" const char rb_asset_${number}[], rb_asset_${number}_end[];\n")
    string(APPEND entries "      {\"${path}\", \"${type}\", {rb_asset_${number}, rb_asset_${number}_end}},\n")
    math(EXPR number "${number} + 1")
  endforeach()
  list(TRANSFORM arg_SOURCES PREPEND ${from}/ OUTPUT_VARIABLE sources)
  add_custom_command(OUTPUT ${files}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${page}/src
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${from}/src ${page}/src
    COMMAND ${CMAKE_COMMAND} -E copy ${from}/tsconfig.json ${page}
    COMMAND ${RB_NODE} ${from}/wire_types.mjs ${page}/src/wire.ts ${arg_WIRE}
    COMMAND ${CMAKE_COMMAND} -E copy ${from}/build.mjs ${page}
    COMMAND ${CMAKE_COMMAND} -E chdir ${page} ${RB_NODE} build.mjs
    DEPENDS ${packages} ${sources} ${wire_files} COMMENT "Building ${target}" VERBATIM)

  set(table ${CMAKE_CURRENT_BINARY_DIR}/${target}_assets.cpp)
  file(CONFIGURE OUTPUT ${table} @ONLY CONTENT
"#include <array>

#include \"host/web/web_server.hpp\"

@assembly@
namespace roadbalance {
std::span<const Asset> page_assets() {
  static const std::array<Asset, @number@> kAssets{{
@entries@  }};
  return kAssets;
}
}  // namespace roadbalance
")
  # cmake forgets what the object of a source in a batch depends on.
  set_source_files_properties(${table} PROPERTIES OBJECT_DEPENDS "${files}" SKIP_UNITY_BUILD_INCLUSION ON)
  rb_library(${target} ${table})
endfunction()
