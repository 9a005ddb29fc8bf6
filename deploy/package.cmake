# What is installed, and the packages for Debian (`cpack` in the build folder; deploy/package.sh):
#   divemesh         the program, its documentation
#   divemesh-server  a service of it, with its user and configuration
#   divemesh-worker  the same for a worker
set(DIVEMESH_PACKAGE_CONTACT "divemesh maintainers <maintainers@divemesh.invalid>" CACHE STRING "Maintainer of the packages")

set(debian ${PROJECT_SOURCE_DIR}/deploy/debian)
set(units ${PROJECT_SOURCE_DIR}/deploy/systemd)
set(packaging ${PROJECT_BINARY_DIR}/packaging)

# Writes a file of deploy/debian, filled in, for a package.
function(divemesh_package_text template output)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC) # heeds SOURCE_DATE_EPOCH
  configure_file(${debian}/${template} ${packaging}/${output} @ONLY
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
endfunction()
# Compresses a file as Debian wants it: the same bytes every time.
function(divemesh_gzip input output)
  execute_process(COMMAND gzip -9nc ${input} OUTPUT_FILE ${packaging}/${output} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

divemesh_package_text(changelog.in changelog)
divemesh_gzip(${packaging}/changelog changelog.gz)
divemesh_gzip(${debian}/divemesh.1 divemesh.1.gz)

install(TARGETS divemesh COMPONENT divemesh)
install(FILES ${packaging}/divemesh.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT divemesh)
# As in the source, so that the pages' links lead somewhere.
set(doc ${CMAKE_INSTALL_DATAROOTDIR}/doc/divemesh)
install(FILES README.md DESTINATION ${doc} COMPONENT divemesh)
install(FILES api/openapi.yaml DESTINATION ${doc}/api COMPONENT divemesh)
install(DIRECTORY docs DESTINATION ${doc} COMPONENT divemesh)
install(DIRECTORY deploy/grafana deploy/proxy DESTINATION ${doc}/deploy COMPONENT divemesh)
foreach(package IN ITEMS divemesh divemesh-server divemesh-worker)
  install(FILES ${debian}/copyright ${packaging}/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${package})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME divemesh)
set(CPACK_PACKAGE_CONTACT ${DIVEMESH_PACKAGE_CONTACT})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL divemesh divemesh-server divemesh-worker)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)

set(CPACK_DEBIAN_DIVEMESH_PACKAGE_NAME divemesh)
set(CPACK_DEBIAN_DIVEMESH_PACKAGE_SHLIBDEPS ON)
# dpkg-shlibdeps does not know the SQL that SQLite has to understand: RETURNING, STRICT, unixepoch().
set(CPACK_DEBIAN_DIVEMESH_PACKAGE_DEPENDS "libsqlite3-0 (>= 3.38)")
set(CPACK_DEBIAN_DIVEMESH_PACKAGE_RECOMMENDS ca-certificates)
set(CPACK_COMPONENT_DIVEMESH_DESCRIPTION "recorded dives become measured 3D models
The program for laboratory and field: it reconstructs the recording of a stereo
camera with an IMU, reports how accurate the result is, compares dives, and is
the client of a server. Start with `divemesh demo`.")

# A service: the unit, its user, its configuration.
function(divemesh_package_service package config)
  install(FILES ${units}/${package}.service DESTINATION lib/systemd/system COMPONENT ${package})
  install(FILES ${units}/sysusers.conf DESTINATION lib/sysusers.d RENAME ${package}.conf COMPONENT ${package})
  install(FILES ${units}/${config} DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/divemesh COMPONENT ${package})
  foreach(script IN ITEMS postinst prerm postrm)
    divemesh_package_text(${script}.in ${package}/${script})
    list(APPEND control ${packaging}/${package}/${script})
  endforeach()
  file(CONFIGURE OUTPUT ${packaging}/${package}/conffiles CONTENT "${CMAKE_INSTALL_FULL_SYSCONFDIR}/divemesh/${config}\n")
  list(APPEND control ${packaging}/${package}/conffiles)
  string(TOUPPER ${package} name)
  set(CPACK_DEBIAN_${name}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${name}_PACKAGE_DEPENDS "systemd | systemd-standalone-sysusers" PARENT_SCOPE)
  set(CPACK_DEBIAN_${name}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
  set(CPACK_DEBIAN_${name}_PACKAGE_CONTROL_EXTRA ${control} PARENT_SCOPE)
  set(CPACK_COMPONENT_${name}_DEPENDS divemesh PARENT_SCOPE)
endfunction()
divemesh_package_service(divemesh-server server.toml)
set(CPACK_DEBIAN_DIVEMESH-SERVER_PACKAGE_RECOMMENDS divemesh-worker)
set(CPACK_COMPONENT_DIVEMESH-SERVER_DESCRIPTION "server for recorded dives and their 3D models
A service that takes dives over unreliable links, queues their reconstruction
and serves models, reports and the page. The package divemesh-worker does the
work.")
divemesh_package_service(divemesh-worker worker.toml)
set(CPACK_COMPONENT_DIVEMESH-WORKER_DESCRIPTION "worker that reconstructs the dives of a divemesh server
A service that takes jobs from the queue of divemesh-server on this machine and
runs each in a process of its own, without network.")

include(CPack)
