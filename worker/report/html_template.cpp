#include "worker/report/html_template.hpp"

#include <kainjow/mustache.hpp>
#include <map>
#include <stdexcept>
#include <utility>

#include "worker/report/html_parts.hpp"

namespace divemesh::report {
namespace {

namespace mustache = kainjow::mustache;
using nlohmann::json;

mustache::data to_data(const json& value) {
    switch (value.type()) {
        case json::value_t::null: return {false};
        case json::value_t::boolean: return {value.get<bool>()};
        case json::value_t::string: return {value.get_ref<const std::string&>()};
        case json::value_t::array: {
            mustache::list list;
            for (const json& item : value) list.push_back(to_data(item));
            return {list};
        }
        case json::value_t::object: {
            mustache::data object;
            for (const auto& [name, item] : value.items()) object[name] = to_data(item);
            return object;
        }
        default: return {value.dump()};
    }
}

// Throws for a missing name. Mustache leaves it out, but here it is a bug.
class StrictContext : public mustache::context<std::string> {
public:
    explicit StrictContext(const mustache::data& values) : context(&values) {
        for (const auto& [name, text] : html_parts())
            parts_.emplace(name, mustache::data(std::string(text)));
    }

    const mustache::data* get(const std::string& name) const override {
        if (const mustache::data* found = context::get(name)) return found;
        throw std::logic_error("the template has {{" + name + "}}, its values have not");
    }

    const mustache::data* get_partial(const std::string& name) const override {
        const auto found = parts_.find(name);
        if (found != parts_.end()) return &found->second;
        throw std::logic_error("there is no part {{>" + name + "}}");
    }

private:
    std::map<std::string, mustache::data> parts_;
};

}  // namespace

std::string fill_template(std::string_view text, const json& values) {
    mustache::mustache page{std::string(text)};
    const mustache::data data = to_data(values);
    StrictContext context(data);
    std::string filled = page.is_valid() ? page.render(context) : "";
    if (!page.is_valid()) throw std::logic_error("malformed template: " + page.error_message());
    return filled;
}

}  // namespace divemesh::report
