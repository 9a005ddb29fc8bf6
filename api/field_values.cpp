#include "api/field_values.hpp"

#include <algorithm>

namespace divemesh::api {
namespace {

// Returns the text in lower case, without the spaces around it.
std::string plain(std::string_view text) {
    const auto first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return "";
    std::string result(text.substr(first, text.find_last_not_of(" \t") - first + 1));
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return result;
}

}  // namespace

std::vector<std::string> list_elements(std::string_view field) {
    std::vector<std::string> elements;
    for (std::size_t start = 0; start <= field.size();) {
        const std::size_t end = std::min(field.find(',', start), field.size());
        std::string element = plain(field.substr(start, end - start));
        if (!element.empty()) elements.push_back(std::move(element));
        start = end + 1;
    }
    return elements;
}

std::string media_type_of(std::string_view field) {
    return plain(field.substr(0, field.find(';')));
}

}  // namespace divemesh::api
