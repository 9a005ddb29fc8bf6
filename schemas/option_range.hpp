#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// The values that an option may have. Texts without words, and flags, may have any.
struct OptionRange {
    std::optional<double> min = std::nullopt;
    std::optional<double> max = std::nullopt;
    bool above_min = false;      // min itself is not allowed
    int multiple_of = 0;         // 0: any number
    std::string_view zero = "";  // what 0 means; "": no more than that number. 0 is allowed then
    std::vector<std::string_view> words{};
    bool is_list = false;  // of words, separated by commas

    bool allows(double number) const;
    bool allows(std::string_view word) const;
    // Returns e.g. "must be 0 (automatic) or 0.0005 to 1 m"; `unit` may be "".
    std::string rule(std::string_view unit) const;
};

// Returns the unit that ends an option's name: "m" of voxel_m; "" if it has none.
std::string_view unit_in_name(std::string_view name);

// Returns what the API shows of a range. Limits that there are not are null.
nlohmann::json range_to_json(const OptionRange& range);

// Returns every option of a reconstruction for the API: a list of objects with name, type, unit,
// help, the allowed values (range_to_json()) and "defaults", a value for each preset.
nlohmann::json describe_options();

}  // namespace divemesh
