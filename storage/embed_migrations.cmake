# Writes the .sql files given as FILES into one .cpp, so that the program carries them.
set(text "#include \"storage/migrations.hpp\"\n\nnamespace divemesh::storage {\n\n")
string(APPEND text "const std::vector<std::string>& migrations() {\n    static const std::vector<std::string> all = {\n")
foreach(file IN LISTS FILES)
  file(READ ${file} sql)
  string(APPEND text "R\"sql(${sql})sql\",\n")
endforeach()
string(APPEND text "    };\n    return all;\n}\n\n}  // namespace divemesh::storage\n")
file(WRITE ${OUTPUT} "${text}")
