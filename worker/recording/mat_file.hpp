#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::recording {

// A value of Matlab's: a matrix of numbers, a text or a struct. What is none of these, or is larger
// than any calibration's, is empty.
struct MatValue {
    std::size_t num_rows = 0;
    std::vector<double> numbers;  // by columns, as Matlab stores them
    std::string text;
    std::map<std::string, MatValue> fields;
    bool is_object = false;  // of a class, which Matlab alone can read

    // Returns a field of a struct; an empty value if it has none of this name.
    const MatValue& at(const std::string& name) const;
    bool has(const std::string& name) const { return fields.contains(name); }
};

// Returns whether bytes begin as a MAT-file of version 5 or 7.3 does.
bool is_mat(std::string_view bytes);

// Returns the variables of a MAT-file of version 5 (Matlab's -v6 and -v7) as the fields of a
// struct, written after MathWorks' description "MAT-File Format". Throws Error{BadData}, which
// names the file, if it is damaged or of another version.
MatValue parse_mat(std::string_view bytes, const std::string& file);

}  // namespace divemesh::recording
