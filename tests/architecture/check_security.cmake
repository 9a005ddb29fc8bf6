# Run as: cmake -D SOURCE_DIRECTORY=... -P check_security.cmake
# docs/security.md names the test that shows how a requirement is met: each of them exists.
cmake_minimum_required(VERSION 3.25)

file(GLOB_RECURSE sources ${SOURCE_DIRECTORY}/tests/*_test.cpp)
set(tests "")
foreach(source IN LISTS sources)
  file(READ ${source} text)
  string(REGEX MATCHALL "TEST(_F|_P)?\\([A-Za-z0-9]+,[ \n]+[A-Za-z0-9]+\\)" found "${text}")
  string(REGEX REPLACE "TEST(_F|_P)?\\(([A-Za-z0-9]+),[ \n]+([A-Za-z0-9]+)\\)" "\\2.\\3" found "${found}")
  list(APPEND tests ${found})
endforeach()

file(READ ${SOURCE_DIRECTORY}/docs/security.md text)
string(REGEX MATCHALL "`[A-Z][A-Za-z0-9]*Test\\.[A-Za-z0-9]+`" named "${text}")
if(NOT named)
  message(SEND_ERROR "docs/security.md: it names no test")
endif()
foreach(name IN LISTS named)
  string(REPLACE "`" "" name ${name})
  if(NOT name IN_LIST tests)
    message(SEND_ERROR "docs/security.md: no test ${name}")
  endif()
endforeach()
