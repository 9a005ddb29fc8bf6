#include "storage/catalog_url.hpp"

#include <algorithm>

namespace divemesh::storage {

bool is_postgresql_url(const std::string& url) {
    return url.starts_with("postgresql://") || url.starts_with("postgres://");
}

std::string without_password(const std::string& url) {
    if (url.starts_with("sqlite://") || url.find(':') == std::string::npos) return url;
    std::string shown = url;
    const std::string name = "password=";
    for (auto at = shown.find(name); at != std::string::npos; at = shown.find(name, at + 1)) {
        const auto begin = at + name.size();
        const auto end = std::min(shown.find('&', begin), shown.size());
        shown.replace(begin, end - begin, "***");
    }
    // A password may hold an @ or a slash that should have been escaped: the last @ counts.
    const auto scheme = shown.find("://");
    const auto authority = scheme == std::string::npos ? shown.find(':') + 1 : scheme + 3;
    const auto at = shown.rfind('@');
    if (at == std::string::npos || at < authority) return shown;
    const auto colon = shown.find(':', authority);
    if (colon < at) shown.replace(colon + 1, at - colon - 1, "***");
    return shown;
}

}  // namespace divemesh::storage
