# Debian packages of what was built:  cpack --preset release
#
#   roadbalance-node    rb-node with its unit, the front-end board's udev rule
#   roadbalance-host    recorder, analyser, list of recordings and page with their units
#   roadbalance-tools   rb and rb-study, the guide with its car, vehicle files to begin with and their pages
#   roadbalance-cluster rb-mpi, where it was built: of its own, for no car needs MPI and ssh
#
# cpack --preset arm64 makes them for 64-bit ARM, without the cluster's.
# Each file's package is named where the file is built (rb_program(... PACKAGE name), rb_unit).

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME roadbalance)
set(CPACK_PACKAGE_VENDOR roadbalance)
set(CPACK_PACKAGE_CONTACT "roadbalance <maintainers@roadbalance.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL node host tools)
if(TARGET rb-mpi)
  list(APPEND CPACK_COMPONENTS_ALL cluster)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_STRIP_FILES TRUE)
set(CPACK_DEB_COMPONENT_INSTALL TRUE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS TRUE)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)

set(CPACK_DEBIAN_NODE_DESCRIPTION "balances wheels on the moving car: the nodes
Samples accelerations, wheel encoders and the car's buses, and streams them to the
recorder without loss.")
set(CPACK_DEBIAN_HOST_DESCRIPTION "balances wheels on the moving car: the laptop
Records what nodes send, analyses it while it comes, and shows it in a browser:
spectra, coherence, the unbalance of each wheel and the weights to clip on.")
set(CPACK_DEBIAN_TOOLS_DESCRIPTION "balances wheels on the moving car: the command line
Proves recordings complete, identifies tyres and unbalances, exports and reports;
a simulated car to try all of it.")
set(CPACK_DEBIAN_CLUSTER_DESCRIPTION "balances wheels on the moving car: over a cluster
Identifies a car from hundreds of recorded drives, and repeats studies over many
seeds, on all machines that mpirun begins it on.")
set(CPACK_DEBIAN_CLUSTER_PACKAGE_DEPENDS openmpi-bin) # mpirun
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS TRUE)
set(CPACK_COMPONENT_HOST_DEPENDS tools) # the jobs of its page call rb
set(CPACK_DEBIAN_NODE_PACKAGE_RECOMMENDS roadbalance-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS "roadbalance-node, roadbalance-host, python3") # rb demo, and the guide's car

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} package)
  set(scripts ${PROJECT_SOURCE_DIR}/tools/packages/${component})
  if(IS_DIRECTORY ${scripts})
    set(CPACK_DEBIAN_${package}_PACKAGE_CONTROL_EXTRA ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm)
    # LCM's receivers are given this; rb doctor names it.  A machine may have either package, or both.
    install(FILES ${PROJECT_SOURCE_DIR}/tools/packages/sysctl.conf DESTINATION lib/sysctl.d COMPONENT ${component}
      RENAME 60-roadbalance-${component}.conf)
  endif()
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/roadbalance-${component} COMPONENT ${component}
    RENAME copyright)
endforeach()
# Pages and first files lie as they do in the repository, because their links and names of files are relative.
set(pages README.md CHANGELOG.md SECURITY.md tools/README.md tools/guide/README.md tools/guide/reference.md tools/guide/page.png
  common/vehicle/conventions.md common/config/README.md common/multibody/README.md common/dbc/README.md
  firmware/backends/README.md firmware/backends/gpio/README.md firmware/backends/socketcan/README.md
  firmware/backends/usb/README.md host/recording/formats/README.md host/recording/subset/README.md host/web/README.md
  sim/demo/vehicle.toml sim/demo/vehicle-3-nodes.toml sim/demo/scenario.toml)
foreach(page IN LISTS pages)
  get_filename_component(place ${page} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/${page} DESTINATION share/doc/roadbalance-tools/${place} COMPONENT tools)
endforeach()
install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/guide/car DESTINATION share/doc/roadbalance-tools/tools/guide COMPONENT tools)

if(CMAKE_CROSSCOMPILING)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
  set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/tools/packages/arm64.cmake)
endif()
include(CPack)
