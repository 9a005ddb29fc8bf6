# Files that the program carries. Included by the root CMakeLists.txt this is a function, run by `cmake -P` it is what
# that function lets the build run.
#
#   divemesh_embed_files(target header [LIST name] files...)
#
# compiles the text of each file into `target`, again whenever the file changes. `header`, from the root, declares what
# comes of them, in the namespace it is declared in: of metrics.schema.json `std::string_view metrics_schema_json()`.
# With LIST one function returns them all in their order: `const std::vector<std::string>& name()`.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(divemesh_embed_script ${CMAKE_CURRENT_LIST_FILE})
  function(divemesh_embed_files target header)
    cmake_parse_arguments(EMBED "" "LIST" "" ${ARGN})
    set(files "")
    foreach(file IN LISTS EMBED_UNPARSED_ARGUMENTS)
      get_filename_component(file ${file} ABSOLUTE)
      list(APPEND files ${file})
    endforeach()
    set(output ${PROJECT_BINARY_DIR}/embedded/${header}.cpp)
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -DHEADER=${header} -DLIST=${EMBED_LIST} "-DFILES=${files}"
              -DOUTPUT=${output} -P ${divemesh_embed_script}
      DEPENDS ${files} ${PROJECT_SOURCE_DIR}/${header} ${divemesh_embed_script}
      COMMENT "Embedding for ${header}"
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endfunction()
  return()
endif()

file(READ ${ROOT}/${HEADER} declarations)
if(NOT declarations MATCHES "namespace ([a-z0-9_:]+) {")
  message(FATAL_ERROR "${HEADER} declares no namespace for what is embedded")
endif()
set(namespace ${CMAKE_MATCH_1})
set(body "")
foreach(file IN LISTS FILES)
  file(READ ${file} text)
  # The end of a raw string: 16 digits that a text would have to contain of its own hash.
  string(SHA256 hash "${text}")
  string(SUBSTRING ${hash} 0 16 end)
  set(literal "R\"${end}(${text})${end}\"")
  if(LIST)
    string(APPEND body "        ${literal},\n")
  else()
    get_filename_component(name ${file} NAME)
    string(MAKE_C_IDENTIFIER ${name} function)
    string(APPEND body "std::string_view ${function}() { return ${literal}; }\n")
  endif()
endforeach()
if(LIST)
  string(PREPEND body "const std::vector<std::string>& ${LIST}() {\n    static const std::vector<std::string> kAll = {\n")
  string(APPEND body "    };\n    return kAll;\n}\n")
endif()
file(WRITE ${OUTPUT} "#include \"${HEADER}\"\n\nnamespace ${namespace} {\n\n${body}\n}  // namespace ${namespace}\n")
