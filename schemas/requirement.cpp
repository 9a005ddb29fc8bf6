#include "schemas/requirement.hpp"

#include <charconv>
#include <cmath>

#include "schemas/metric.hpp"
#include "schemas/trimmed.hpp"

namespace divemesh {
namespace {

constexpr std::size_t kMaxLength = 500;

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
    throw Error(ErrorCode::InvalidArgument,
                std::string("requirement '")
                    .append(text.substr(0, 120))
                    .append("': " + why + ": write METRIC<=NUMBER, with <=, >=, < or >"));
}

double parse_limit(std::string_view text, std::string_view whole) {
    double value = 0.0;
    const std::string_view digits = text.starts_with('+') ? text.substr(1) : text;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
        refuse(whole, std::string("'").append(text.substr(0, 40)).append("' is not a number"));
    return value;
}

}  // namespace

Requirement parse_requirement(std::string_view text) {
    if (text.size() > kMaxLength) refuse(text, "it is too long");
    // The last one, because names of entries may contain such signs.
    const auto sign = text.find_last_of("<>");
    if (sign == std::string_view::npos) refuse(text, "it has no <=, >=, < or >");
    const bool or_equal = sign + 1 < text.size() && text[sign + 1] == '=';
    const auto metric = trimmed(text.substr(0, sign));
    if (metric.empty()) refuse(text, "it names no metric");
    Requirement requirement;
    requirement.text = std::string(text);
    requirement.limit = parse_limit(trimmed(text.substr(sign + (or_equal ? 2 : 1))), text);
    requirement.metric = resolve_metric(metric);
    if (text[sign] == '<')
        requirement.comparison = or_equal ? Comparison::LessOrEqual : Comparison::Less;
    else
        requirement.comparison = or_equal ? Comparison::GreaterOrEqual : Comparison::Greater;
    return requirement;
}

bool is_met(const Requirement& requirement, double value) {
    switch (requirement.comparison) {
        case Comparison::LessOrEqual: return value <= requirement.limit;
        case Comparison::GreaterOrEqual: return value >= requirement.limit;
        case Comparison::Less: return value < requirement.limit;
        case Comparison::Greater: return value > requirement.limit;
    }
    return false;
}

}  // namespace divemesh
