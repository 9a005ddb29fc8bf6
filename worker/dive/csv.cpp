#include "worker/dive/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "schemas/trimmed.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxFields = 32;

// Returns the text of a field, without the quotes that spreadsheets write around it.
std::string_view unquoted(std::string_view field) {
    if (field.size() < 2 || field.front() != '"' || field.back() != '"') return field;
    return trimmed(field.substr(1, field.size() - 2));
}

template <typename Number>
std::optional<Number> parse_number(std::string_view field) {
    if (field.starts_with('+')) field.remove_prefix(1);
    Number value{};
    const char* const end = field.data() + field.size();
    const auto result = std::from_chars(field.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end) return std::nullopt;
    return value;
}

}  // namespace

void for_each_csv_row(
    std::string_view text,
    const std::function<void(std::int64_t line, std::span<const std::string_view> fields)>& row) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    std::array<std::string_view, kMaxFields> fields;
    bool heading_may_come = true;
    for (std::int64_t line = 1; !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view rest = trimmed(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        if (rest.empty() || rest.front() == '#') continue;
        std::size_t num_fields = 0;
        for (bool more = true; more && num_fields < kMaxFields;) {
            const std::size_t comma = rest.find(',');
            more = comma != std::string_view::npos;
            fields[num_fields++] = unquoted(trimmed(rest.substr(0, comma)));
            if (more) rest.remove_prefix(comma + 1);
        }
        const bool is_heading = heading_may_come && !parse_double(fields[0]);
        heading_may_come = false;
        if (!is_heading) row(line, {fields.data(), num_fields});
    }
}

std::optional<std::int64_t> parse_integer(std::string_view field) {
    return parse_number<std::int64_t>(field);
}

std::optional<double> parse_double(std::string_view field) { return parse_number<double>(field); }

}  // namespace divemesh::dive
