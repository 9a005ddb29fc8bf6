#include "worker/dive/table_advice.hpp"

#include <algorithm>

#include "worker/dive/csv.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMinTimestamp_ns = 1e9;  // one second; a count of rows stays below

// Returns the first line that begins with a digit or has more than one field: no comment or
// heading.
std::string_view first_row(std::string_view text) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        if (!line.empty() && (line.front() >= '0' && line.front() <= '9')) return line;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return {};
}

bool is_separated_by(std::string_view line, char separator) {
    const std::size_t place = line.find(separator);
    return place != std::string_view::npos && parse_double(line.substr(0, place)).has_value();
}

std::string_view field(std::string_view line, std::size_t index) {
    for (; index > 0; --index) {
        const std::size_t comma = line.find(',');
        if (comma == std::string_view::npos) return {};
        line.remove_prefix(comma + 1);
    }
    return line.substr(0, line.find(','));
}

}  // namespace

TableAdvice advise_on_table(std::string_view text, std::size_t num_values) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
        return {"it is in UTF-16", "Save the table as UTF-8."};
    const std::string_view line = first_row(text);
    if (line.empty()) return {};
    for (const auto& [separator, name] :
         {std::pair{';', "semicolons"}, std::pair{'\t', "tabs"}, std::pair{' ', "blanks"}})
        if (is_separated_by(line, separator))
            return {std::string("its fields are separated by ") + name,
                    "Export the table as CSV with commas between the fields and points in "
                    "decimals."};
    const auto first = parse_double(field(line, 0));
    const auto second = parse_double(field(line, 1));
    if (first && *first < kMinTimestamp_ns && second && *second >= kMinTimestamp_ns)
        return {"its first column counts the rows and the second is the timestamp",
                "Remove the first column (pandas: to_csv(..., index=False))."};
    if (first && field(line, 0).find_first_of("eE") != std::string_view::npos)
        return {
            "its timestamps are in exponential notation, as spreadsheets write them, so their "
            "last digits are lost",
            "Take the table as the recorder wrote it, not from a spreadsheet."};
    if (first && field(line, 0).find('.') != std::string_view::npos)
        return {"its timestamps have a fraction, as seconds have",
                "Write timestamps as whole nanoseconds: seconds times 1e9."};
    const auto num_fields = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
    if (num_fields < num_values + 1)
        return {"its rows have " + std::to_string(num_fields) + " of " +
                    std::to_string(num_values + 1) + " columns",
                num_values == 1 ? "Write in column 2 the file name of the image."
                                : "Write a timestamp and " + std::to_string(num_values) +
                                      " values in each row."};
    return {};
}

}  // namespace divemesh::dive
