#include "storage/storable_text.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace divemesh::storage {

std::optional<std::string> storable_text(const std::string& text) {
    using nlohmann::json;
    const auto is_plain = [](char c) { return static_cast<signed char>(c) > 0; };
    if (std::all_of(text.begin(), text.end(), is_plain)) return std::nullopt;
    const std::string valid =
        json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace))
            .get<std::string>();
    std::string storable;
    for (const char c : valid) {
        if (c == '\0')
            storable += "\uFFFD";
        else
            storable += c;
    }
    if (storable == text) return std::nullopt;
    return storable;
}

}  // namespace divemesh::storage
