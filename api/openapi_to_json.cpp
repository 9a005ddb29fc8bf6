// openapi_to_json IN.yaml OUT.json: runs during the build, so that the server parses no YAML.
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <yaml-cpp/yaml.h>

namespace {

// "!" is the tag of a quoted scalar, which is always a string.
nlohmann::json scalar(const YAML::Node& node) {
    const std::string& text = node.Scalar();
    if (node.Tag() == "!") return text;
    if (text == "true" || text == "false") return text == "true";
    if (text == "null" || text == "~") return nullptr;
    const auto number = nlohmann::json::parse(text, nullptr, false);
    return number.is_number() ? number : nlohmann::json(text);
}

nlohmann::json to_json(const YAML::Node& node) {
    if (node.IsScalar()) return scalar(node);
    nlohmann::json json;
    if (node.IsSequence())
        for (const auto& item : node) json.push_back(to_json(item));
    if (node.IsMap())
        for (const auto& pair : node) json[pair.first.Scalar()] = to_json(pair.second);
    if (json.is_null() && node.IsSequence()) json = nlohmann::json::array();
    if (json.is_null() && node.IsMap()) json = nlohmann::json::object();
    return json;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    try {
        const std::string text = to_json(YAML::LoadFile(argv[1])).dump();
        std::ofstream out(argv[2]);
        out << text;
        return out.flush() ? 0 : 1;
    } catch (const std::exception& error) {
        std::cerr << argv[1] << ": " << error.what() << '\n';
        return 1;
    }
}
