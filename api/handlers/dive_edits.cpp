#include "api/handlers/dive_edits.hpp"

#include <algorithm>
#include <cmath>

#include "api/handlers/resource.hpp"
#include "api/visible.hpp"
#include "schemas/invalid_input.hpp"
#include "storage/dive_store.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxWordBytes = 200;
constexpr std::size_t kMaxNotesBytes = 10'000;
constexpr std::size_t kMaxTags = 64;

[[noreturn]] void refuse(const std::string& message, const std::string& pointer) {
    throw InvalidInput({{message, pointer, ""}});
}

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

void check_word(const json& value, const std::string& pointer) {
    if (!value.is_string()) refuse("it must be a text", pointer);
    const auto& text = value.get_ref<const std::string&>();
    if (text.size() > kMaxWordBytes) refuse("it is longer than 200 bytes", pointer);
    if (std::any_of(text.begin(), text.end(), is_control))
        refuse("it holds a control character", pointer);
}

void check_name(const json& value, const std::string& pointer) {
    check_word(value, pointer);
    if (value.get_ref<const std::string&>().empty()) refuse("a dive needs a name", pointer);
}

void check_notes(const json& value, const std::string& pointer) {
    if (!value.is_string()) refuse("it must be a text", pointer);
    if (value.get_ref<const std::string&>().size() > kMaxNotesBytes)
        refuse("it is longer than 10000 bytes", pointer);
}

void check_tags(const json& value, const std::string& pointer) {
    if (!value.is_array() || value.size() > kMaxTags)
        refuse("it must be a list of 64 tags at most", pointer);
    for (std::size_t i = 0; i < value.size(); ++i)
        check_word(value[i], pointer + "/" + std::to_string(i));
}

void check_degrees(const json& position,
                   const std::string& key,
                   double max,
                   const std::string& at) {
    const auto found = position.find(key);
    if (found == position.end() || !found->is_number() || std::abs(found->get<double>()) > max)
        refuse("it must be a number from -" + std::to_string(static_cast<int>(max)) + " to " +
                   std::to_string(static_cast<int>(max)),
               at + "/" + key);
}

void check_position(const json& value, const std::string& pointer) {
    if (!value.is_object() || value.size() != 2)
        refuse("it must be {\"latitude_deg\": ..., \"longitude_deg\": ...}", pointer);
    check_degrees(value, "latitude_deg", 90.0, pointer);
    check_degrees(value, "longitude_deg", 180.0, pointer);
}

struct Field {
    const char* name;
    void (*check)(const json& value, const std::string& pointer);
};

constexpr Field kFields[] = {{"name", check_name},
                             {"site", check_word},
                             {"rig", check_word},
                             {"tags", check_tags},
                             {"notes", check_notes},
                             {"position", check_position}};

json description_patch(const Request& request) {
    std::set<std::string> names;
    for (const Field& field : kFields) names.insert(field.name);
    json patch = json_body(request, names);
    for (const Field& field : kFields)
        if (patch.contains(field.name) && !patch[field.name].is_null())
            field.check(patch[field.name], pointer_to(field.name));
    return patch;
}

}  // namespace

Awaitable<Response> edit_dive(Request request, Services services) {
    auto edit = [services](const Request& asked) {
        const std::string id = visible_dive(asked, services.catalog).id;
        auto catalog = audited_if_match(services, asked, [services, asked] {
            return json(visible_dive(asked, services.catalog));
        });
        return storage::DiveStore(catalog).edit(id, description_patch(asked));
    };
    return change_resource(std::move(request), services, edit);
}

}  // namespace divemesh::api
