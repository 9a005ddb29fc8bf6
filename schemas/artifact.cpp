#include "schemas/artifact.hpp"

#include <string_view>
#include <utility>

namespace divemesh {

std::string media_type_of(const std::string& name) {
    static constexpr std::pair<std::string_view, std::string_view> kTypes[] = {
        {".glb", "model/gltf-binary"},
        {".ply", "application/vnd.ply"},
        {".obj", "model/obj"},
        {".png", "image/png"},
        {".jpg", "image/jpeg"},
        {".json", "application/json"},
        {".html", "text/html; charset=utf-8"},
        {".tum", "text/plain; charset=utf-8"},
        {".csv", "text/csv; charset=utf-8"},
        {".txt", "text/plain; charset=utf-8"},
        {".xml", "application/xml"},
    };
    for (const auto& [extension, type] : kTypes)
        if (name.ends_with(extension)) return std::string(type);
    return "application/octet-stream";
}

}  // namespace divemesh
