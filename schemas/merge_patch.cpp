#include "schemas/merge_patch.hpp"

#include <utility>

namespace divemesh {

using nlohmann::json;

json without_nulls(json document) {
    if (!document.is_object()) return document;
    json kept = json::object();
    for (auto& [key, value] : document.items())
        if (!value.is_null()) kept[key] = without_nulls(std::move(value));
    return kept;
}

json merge_patch(const json& from, const json& to) {
    if (!from.is_object() || !to.is_object()) return to;
    json patch = json::object();
    for (const auto& [key, value] : from.items())
        if (!to.contains(key)) patch[key] = nullptr;
    for (const auto& [key, value] : to.items()) {
        const auto before = from.find(key);
        if (before == from.end())
            patch[key] = value;
        else if (*before != value)
            patch[key] = merge_patch(*before, value);
    }
    return patch;
}

}  // namespace divemesh
