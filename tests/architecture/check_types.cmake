# Run as: cmake -D SOURCE_DIRECTORY=... -P check_types.cmake
# No type is defined twice: two types of one qualified name in one program break the one-definition
# rule, and no compiler or linker says so. Namespace is folder, so that two folders may use one word.
# Lines at column 0 suffice: the formatter indents whatever lies inside a type or a function.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/layers.cmake)

# The namespace that the code of a file lives in; forward declarations may open others.
function(namespace_of file result)
  if(file MATCHES "^worker/([^/]+)/")
    set(${result} "divemesh::${CMAKE_MATCH_1}" PARENT_SCOPE)
  elseif(file MATCHES "^schemas/")
    set(${result} "divemesh" PARENT_SCOPE) # the words: every other namespace sees them
  elseif(file MATCHES "^api/client/")
    set(${result} "divemesh::api::client" PARENT_SCOPE) # the other side of the connection
  elseif(file MATCHES "^([^/]+)/")
    set(${result} "divemesh::${CMAKE_MATCH_1}" PARENT_SCOPE)
  endif()
endfunction()

function(check_file file)
  if(file MATCHES "\\.simd\\.hpp$")
    return() # included inside a namespace
  endif()
  namespace_of(${file} expected)
  file(STRINGS ${SOURCE_DIRECTORY}/${file} lines
    REGEX "^(namespace .*{$|}  // namespace|int main\\(|(struct|class|union|enum class|enum) [A-Za-z_0-9(]+)")
  if(NOT lines MATCHES "(^|;)(namespace ${expected}(::[a-z_0-9:]+)? {|int main\\()")
    message(SEND_ERROR "${file}: nothing in it is in namespace ${expected}")
  endif()
  set(namespace "")
  set(is_hidden FALSE)
  foreach(line IN LISTS lines)
    if(line MATCHES "^namespace ([a-z_0-9:]+) {$")
      set(namespace ${CMAKE_MATCH_1}) # one of a single line ends without the comment
    elseif(line MATCHES "^namespace {$")
      set(is_hidden TRUE)
    elseif(line MATCHES "^}  // namespace ([a-z_0-9:]+)")
      set(namespace "")
    elseif(line MATCHES "^}  // namespace")
      set(is_hidden FALSE)
    elseif(line MATCHES "^(struct|class|union|enum class|enum) (alignas\\([^)]*\\) )?([A-Za-z_0-9]+)( final)?( :[^;]*)?( {|$)" AND NOT is_hidden)
      set(type ${CMAKE_MATCH_3})
      if(NOT namespace MATCHES "^${expected}(::|$)")
        message(SEND_ERROR "${file}: ${type} is in namespace ${namespace}, not in ${expected}")
      endif()
      get_property(other GLOBAL PROPERTY "definition of ${namespace}::${type}")
      if(other)
        message(SEND_ERROR "${namespace}::${type} is defined twice: ${other}, ${file}")
      endif()
      set_property(GLOBAL PROPERTY "definition of ${namespace}::${type}" ${file})
      get_property(num GLOBAL PROPERTY num_types)
      math(EXPR num "0${num} + 1" OUTPUT_FORMAT DECIMAL)
      set_property(GLOBAL PROPERTY num_types ${num})
    endif()
  endforeach()
endfunction()

foreach(folder IN LISTS top_folders)
  file(GLOB_RECURSE files RELATIVE ${SOURCE_DIRECTORY}
    ${SOURCE_DIRECTORY}/${folder}/*.hpp ${SOURCE_DIRECTORY}/${folder}/*.cpp)
  foreach(file IN LISTS files)
    check_file(${file})
  endforeach()
endforeach()
get_property(num GLOBAL PROPERTY num_types)
message(STATUS "${num} types, each defined once")
if(NOT num OR num LESS 300)
  message(SEND_ERROR "only ${num} types found below ${SOURCE_DIRECTORY}")
endif()
