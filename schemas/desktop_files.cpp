#include "schemas/desktop_files.hpp"

#include <cctype>
#include <string>

namespace divemesh {

bool is_left_by_desktop(std::string_view path) {
    std::string name(path.substr(path.rfind('/') + 1));
    if (name == ".DS_Store" || name.starts_with("._")) return true;
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return name == "thumbs.db" || name == "desktop.ini";
}

}  // namespace divemesh
