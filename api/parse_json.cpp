#include "api/parse_json.hpp"

#include <set>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/invalid_input.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 32;  // deeper nesting is an attack on recursive code

// Follows the parser through objects and arrays. The text of a key that occurs twice would mean one
// value to us and another one to whoever checked it before.
class KeyWatch {
public:
    void see(json::parse_event_t event, const json& value) {
        switch (event) {
            case json::parse_event_t::object_start: open_.push_back({}); return;
            case json::parse_event_t::array_start: open_.push_back({.is_array = true}); return;
            case json::parse_event_t::key: return enter(value.get_ref<const std::string&>());
            case json::parse_event_t::object_end:
            case json::parse_event_t::array_end: open_.pop_back(); break;
            case json::parse_event_t::value: break;
        }
        if (!open_.empty() && open_.back().is_array) ++open_.back().index;
    }

private:
    struct Level {
        bool is_array = false;
        std::size_t index = 0;  // of the current element
        std::string key;        // of the current member
        std::set<std::string> keys{};
    };

    void enter(const std::string& key) {
        open_.back().key = key;
        if (open_.back().keys.insert(key).second) return;
        json::json_pointer pointer;
        for (const Level& level : open_)
            pointer /= level.is_array ? std::to_string(level.index) : level.key;
        throw InvalidInput(
            {{"key \"" + key + "\" occurs twice: send it once", pointer.to_string(), ""}});
    }

    std::vector<Level> open_;
};

}  // namespace

json parse_json(std::string_view text) {
    KeyWatch keys;
    const auto watch = [&keys](int depth, json::parse_event_t event, json& value) {
        if (depth > kMaxDepth)
            throw Error(ErrorCode::InvalidArgument, "the body is nested too deeply");
        keys.see(event, value);
        return true;
    };
    try {
        return json::parse(text, watch);
    } catch (const json::exception& error) {
        throw Error(ErrorCode::InvalidArgument,
                    std::string("the body is not JSON: ") + error.what());
    }
}

}  // namespace divemesh::api
