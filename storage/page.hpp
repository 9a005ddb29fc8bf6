#pragma once

#include <string>
#include <vector>

namespace divemesh::storage {

// One page of a list in a stable order (created_at, id), or its reverse. `next_cursor` is opaque
// and "" at the end.
template <typename T>
struct Page {
    std::vector<T> items;
    std::string next_cursor;
};

struct PageRequest {
    int limit = 50;      // 1 to 200
    std::string cursor;  // "" for the first page; Error{InvalidArgument} if it is invalid
    bool newest_first = false;
};

}  // namespace divemesh::storage
