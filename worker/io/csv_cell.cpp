#include "worker/io/csv_cell.hpp"

#include <nlohmann/json.hpp>
#include <string_view>

namespace divemesh::io {

std::string csv_cell(std::string text) {
    if (!text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos)
        text.insert(0, 1, '\'');
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string cell = "\"";
    for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
    return cell + '"';
}

std::string csv_cell_of(const nlohmann::json& value) {
    if (value.is_null()) return "";
    return value.is_string() ? csv_cell(value.get<std::string>()) : value.dump();
}

}  // namespace divemesh::io
