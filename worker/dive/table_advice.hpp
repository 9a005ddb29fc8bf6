#pragma once

#include <string>
#include <string_view>

namespace divemesh::dive {

// What seems to be wrong with the format of a table as a whole, and what to do.
struct TableAdvice {
    std::string seen;  // "" if it looks as it should
    std::string remedy;
};

// Looks at the first row of a table whose rows should be a timestamp in whole nanoseconds and then
// at least `num_values` fields, separated by commas.
TableAdvice advise_on_table(std::string_view text, std::size_t num_values);

}  // namespace divemesh::dive
