#pragma once

#include <string_view>

namespace divemesh::api {

// A file of the web page. What it refers to lives as long as the program.
struct PageFile {
    std::string_view name;  // "index.html", "assets/main-4f2a.js"
    std::string_view media_type;
    std::string_view sha256;  // of bytes
    std::string_view bytes;
    std::string_view gzip;  // the same, compressed; empty where that saves nothing
};

}  // namespace divemesh::api
