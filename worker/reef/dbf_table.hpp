#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::reef {

// The rows of a dBASE table: the text of each column by its name, without the blanks around it.
using DbfTable = std::vector<std::map<std::string, std::string>>;

// Reads a dBASE III table, which a shapefile has for the attributes of its shapes. Text that is no
// UTF-8 is taken for Latin 1. Throws Error{BadData} if the bytes end before what they announce.
DbfTable read_dbf(std::string_view bytes);

}  // namespace divemesh::reef
