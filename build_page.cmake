# The web page (web/), built by npm and Vite in the build folder. Included by the root CMakeLists.txt this is a
# function, run by `cmake -P` it is one step of the build.
#
#   divemesh_add_page(target)
#
# compiles the page into `target`, which gets page() of cli/page.hpp. DIVEMESH_PAGE=OFF, or AUTO without Node: an empty
# one. Nothing is written into the source tree: web/ is copied to web/ in the build folder, api/openapi.yaml beside it.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(divemesh_page_script ${CMAKE_CURRENT_LIST_FILE})
  set(DIVEMESH_PAGE AUTO CACHE STRING "Build the web page: ON, OFF, or AUTO where Node and npm are found, without sanitizers")
  set_property(CACHE DIVEMESH_PAGE PROPERTY STRINGS AUTO ON OFF)

  # Sets `result` to the reason why the page cannot be built, "" where it can.
  function(divemesh_find_node result)
    find_program(DIVEMESH_NODE node)
    find_program(DIVEMESH_NPM npm)
    set(${result} "" PARENT_SCOPE)
    if(NOT DIVEMESH_NODE OR NOT DIVEMESH_NPM)
      set(${result} "there is no node or no npm: run deploy/install.sh" PARENT_SCOPE)
      return()
    endif()
    execute_process(COMMAND ${DIVEMESH_NODE} --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(REGEX REPLACE "^v" "" version "${version}")
    if(version VERSION_LESS 18)
      set(${result} "${DIVEMESH_NODE} is Node ${version}, and 18 is the oldest that Vite takes" PARENT_SCOPE)
    endif()
  endfunction()

  function(divemesh_page_is_wanted result)
    set(${result} FALSE PARENT_SCOPE)
    if(DIVEMESH_PAGE STREQUAL "AUTO" AND DIVEMESH_SANITIZE)
      return()
    endif()
    if(DIVEMESH_PAGE)
      divemesh_find_node(missing)
      if(NOT missing)
        set(${result} TRUE PARENT_SCOPE)
      elseif(DIVEMESH_PAGE STREQUAL "AUTO")
        message(STATUS "The server is built without the web page: ${missing}")
      else()
        message(FATAL_ERROR "DIVEMESH_PAGE=${DIVEMESH_PAGE}: ${missing}")
      endif()
    endif()
  endfunction()

  # Builds the page into `folder`; `stamp` is written when that is done.
  function(divemesh_build_page folder stamp)
    set(web ${PROJECT_SOURCE_DIR}/web)
    set(work ${PROJECT_BINARY_DIR}/web)
    file(GLOB sources CONFIGURE_DEPENDS ${web}/*.html ${web}/*.js ${web}/*.json ${web}/*.ts)
    file(GLOB_RECURSE more CONFIGURE_DEPENDS ${web}/src/* ${web}/public/*)
    list(APPEND sources ${more})
    list(FILTER sources EXCLUDE REGEX "\\.d\\.ts$") # `npm run check` leaves it; the build makes its own
    set(installed ${work}/node_modules/.package-lock.json) # npm writes it last
    add_custom_command(
      OUTPUT ${installed}
      COMMAND ${CMAKE_COMMAND} -DSTEP=install -DNPM=${DIVEMESH_NPM} -DWEB=${web} -DWORK=${work} -P ${divemesh_page_script}
      DEPENDS ${web}/package.json ${web}/package-lock.json
      COMMENT "Installing the packages of the web page"
      VERBATIM)
    add_custom_command(
      OUTPUT ${stamp}
      COMMAND ${CMAKE_COMMAND} -DSTEP=build -DNPM=${DIVEMESH_NPM} -DWEB=${web} -DWORK=${work} -DFOLDER=${folder}
              "-DSOURCES=${sources}" -P ${divemesh_page_script}
      COMMAND ${CMAKE_COMMAND} -E touch ${stamp}
      DEPENDS ${installed} ${sources} ${PROJECT_SOURCE_DIR}/api/openapi.yaml ${divemesh_page_script}
      COMMENT "Building the web page"
      VERBATIM)
  endfunction()

  function(divemesh_add_page target)
    set(folder "")
    set(stamp "")
    divemesh_page_is_wanted(wanted)
    if(wanted)
      set(folder ${PROJECT_BINARY_DIR}/page)
      set(stamp ${PROJECT_BINARY_DIR}/page.stamp)
      divemesh_build_page(${folder} ${stamp})
    endif()
    set(output ${PROJECT_BINARY_DIR}/embedded/page.cpp)
    add_custom_command(
      OUTPUT ${output}
      COMMAND divemesh_embed_page ${folder} ${output}
      DEPENDS divemesh_embed_page ${stamp}
      COMMENT "Embedding the web page"
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endfunction()
  return()
endif()

function(run_npm advice)
  execute_process(COMMAND ${NPM} ${ARGN} WORKING_DIRECTORY ${WORK}
    RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(failed)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "npm ${command} in ${WORK}:\n${said}\n${advice}")
  endif()
endfunction()

if(STEP STREQUAL "install")
  file(COPY ${WEB}/package.json ${WEB}/package-lock.json DESTINATION ${WORK})
  run_npm("Without a network npm takes the packages from its cache: copy ~/.npm of a machine that has built the page. \
-DDIVEMESH_PAGE=OFF builds the server without it." ci --prefer-offline --no-audit --no-fund --loglevel=error)
  file(TOUCH ${WORK}/node_modules/.package-lock.json)
else()
  file(REMOVE_RECURSE ${WORK}/src ${WORK}/public)
  foreach(source IN LISTS SOURCES)
    file(RELATIVE_PATH name ${WEB} ${source})
    get_filename_component(place ${WORK}/${name} DIRECTORY)
    file(COPY ${source} DESTINATION ${place})
  endforeach()
  file(COPY ${WEB}/../api/openapi.yaml DESTINATION ${WORK}/../api) # the page is typed by it
  run_npm("" run build -- --outDir ${FOLDER} --emptyOutDir)
endif()
