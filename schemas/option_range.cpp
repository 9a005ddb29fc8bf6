#include "schemas/option_range.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh {
namespace {

std::string text_of(double number) { return nlohmann::json(number).dump(); }

// Returns whole numbers without ".0".
std::string plain(double number) {
    return std::trunc(number) == number ? std::to_string(static_cast<long long>(number))
                                        : text_of(number);
}

nlohmann::json limit_to_json(const std::optional<double>& limit) {
    if (!limit) return nullptr;
    return std::trunc(*limit) == *limit ? nlohmann::json(static_cast<long long>(*limit))
                                        : nlohmann::json(*limit);
}

}  // namespace

bool OptionRange::allows(double number) const {
    if (number == 0.0 && !zero.empty()) return true;
    if (min && !(above_min ? number > *min : number >= *min)) return false;
    if (max && !(number <= *max)) return false;
    return multiple_of == 0 || std::fmod(number, multiple_of) == 0.0;
}

bool OptionRange::allows(std::string_view word) const {
    return words.empty() || std::find(words.begin(), words.end(), word) != words.end();
}

std::string OptionRange::rule(std::string_view unit) const {
    std::string text = "must be ";
    const bool zero_apart = !zero.empty() && min && *min > 0.0;
    if (zero_apart) text.append("0 (").append(zero).append(") or ");
    if (multiple_of > 0)
        text.append("a multiple of ").append(std::to_string(multiple_of)).append(" ");
    if (min && above_min) text.append("more than ").append(plain(*min));
    if (min && !above_min && max) text.append(multiple_of > 0 ? "from " : "").append(plain(*min));
    if (min && !above_min && !max) text.append("at least ").append(plain(*min));
    if (min && !zero.empty() && !zero_apart) text.append(" (").append(zero).append(")");
    if (max) text.append(above_min ? " and at most " : " to ").append(plain(*max));
    if (!unit.empty()) text.append(" ").append(unit);
    return text;
}

std::string_view unit_in_name(std::string_view name) {
    for (const std::string_view unit : {"m2", "m", "px", "bytes", "s"}) {
        if (name.size() > unit.size() && name.ends_with(unit) &&
            name[name.size() - unit.size() - 1] == '_')
            return unit == "m2" ? "m²" : unit;
    }
    return "";
}

nlohmann::json range_to_json(const OptionRange& range) {
    return {{"minimum", limit_to_json(range.min)},
            {"maximum", limit_to_json(range.max)},
            {"above_minimum", range.above_min},
            {"multiple_of", range.multiple_of > 0 ? nlohmann::json(range.multiple_of) : nullptr},
            {"zero", range.zero},
            {"words", range.words},
            {"is_list", range.is_list}};
}

}  // namespace divemesh
