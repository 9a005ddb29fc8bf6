#include "worker/reef/outline_file.hpp"

#include <cctype>
#include <regex>

#include "worker/io/geographic_frame.hpp"

namespace divemesh::reef {
namespace {

// Returns lower case letters, with spaces for what programs set differently.
std::string normalised(const std::string& text) {
    std::string plain;
    for (const char c : text)
        plain += c == '_' || c == '/' || c == '\n' || c == '\r' || c == '\t'
                     ? ' '
                     : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return plain;
}

}  // namespace

int epsg_of(const std::string& text) {
    constexpr std::size_t kMaxLength = 500;  // what tells them apart is at the front
    const std::string plain = normalised(text.substr(0, kMaxLength));
    std::smatch found;
    static const std::regex code("^(?:urn:ogc:def:crs:)?epsg:[^:]*:?([0-9]{4,5})$");
    if (std::regex_search(plain, found, code)) {
        const int epsg = std::stoi(found[1]);
        return io::is_wgs84(epsg) ? epsg : 0;
    }
    if (plain.ends_with("crs84")) return io::kLongitudeLatitudeEpsg;
    if (plain.starts_with("local cs") || plain.starts_with("engcrs")) return kLocalCoordinates;
    static const std::regex zone(
        "^proj(?:cs|crs)\\[\"wgs ?(?:19)?84 +utm zone ([0-9]{1,2})([ns])\"");
    if (std::regex_search(plain, found, zone)) {
        const int epsg = (found[2] == "s" ? 32700 : 32600) + std::stoi(found[1]);
        return io::is_wgs84(epsg) ? epsg : 0;
    }
    static const std::regex degrees("^geog(?:cs|crs)\\[\"(?:gcs )?wgs ?(?:19)?84\"");
    return std::regex_search(plain, degrees) ? io::kLongitudeLatitudeEpsg : 0;
}

}  // namespace divemesh::reef
