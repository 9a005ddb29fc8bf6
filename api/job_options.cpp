#include "api/job_options.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "api/handlers/json_body.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/requirement.hpp"
#include "schemas/truth_options.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxRequirements = 100;
constexpr std::size_t kMaxTextBytes = 300;

using Check = std::function<void(const json& value)>;  // throws Error{InvalidArgument}
using Checks = std::map<std::string, Check>;

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorCode::InvalidArgument, why); }

const std::string& text_of(const json& value) {
    if (!value.is_string()) refuse("it must be a text");
    const auto& text = value.get_ref<const std::string&>();
    if (text.empty() || text.size() > kMaxTextBytes) refuse("it is empty or too long");
    return text;
}

void check_text(const json& value) { text_of(value); }

void check_flag(const json& value) {
    if (!value.is_boolean()) refuse("it must be true or false");
}

void check_length(const json& value) {
    if (!value.is_number() || !(value.get<double>() >= 0.0 && value.get<double>() <= 1000.0))
        refuse("it must be a number from 0 to 1000");
}

void check_requirements(const json& value) {
    if (!value.is_array() || value.size() > kMaxRequirements)
        refuse("it must be a list of at most " + std::to_string(kMaxRequirements) +
               " requirements like \"drift_percent<=0.5\"");
    for (const json& item : value) {
        if (!item.is_string()) refuse("a requirement must be a text");
        parse_requirement(item.get_ref<const std::string&>());
    }
}

void check_lever_arm(const json& value) {
    TruthOptions parsed;
    set_lever_arm(parsed, text_of(value));
}

void check_time_offset(const json& value) {
    TruthOptions parsed;
    set_time_offset(parsed, text_of(value));
}

void check(const json& options, const Checks& checks) {
    if (!options.is_object()) throw InvalidInput({{"the options must be an object", "", ""}});
    std::vector<Fault> faults;
    for (const auto& [name, value] : options.items()) {
        const auto known = checks.find(name);
        if (known == checks.end()) {
            faults.push_back({"unknown option \"" + name + "\"", pointer_to(name), ""});
            continue;
        }
        try {
            known->second(value);
        } catch (const Error& error) {
            faults.push_back({"\"" + name + "\": " + error.what(), pointer_to(name), ""});
        }
    }
    if (!faults.empty()) throw InvalidInput(std::move(faults));
}

const Checks& scheduled_checks() {
    static const Checks kChecks = {{"require", check_requirements},
                                   {"lever_arm", check_lever_arm},
                                   {"time_offset", check_time_offset},
                                   {"fresh", check_flag}};
    return kChecks;
}

}  // namespace

void check_scheduled_options(const json& options) { check(options, scheduled_checks()); }

void check_report_options(const json& options) {
    Checks checks = scheduled_checks();
    for (const char* name : {"job", "tag", "ground_truth", "reference", "measurements", "areas"})
        checks[name] = check_text;
    check(options, checks);
}

void check_compare_options(const json& options) {
    Checks checks;
    for (const char* name : {"job", "with", "areas", "later_areas"}) checks[name] = check_text;
    for (const char* name : {"cell_m", "normal_scale_m", "cylinder_m", "reach_m", "least_area_m2"})
        checks[name] = check_length;
    check(options, checks);
}

}  // namespace divemesh::api
