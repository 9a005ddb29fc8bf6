#include "worker/recording/time_table.hpp"

#include <algorithm>
#include <vector>

#include "schemas/trimmed.hpp"
#include "worker/dive/csv.hpp"
#include "worker/recording/civil_time.hpp"

namespace divemesh::recording {
namespace {

using Row = std::vector<std::string>;

// Columns further to the right hold no time of a row.
constexpr std::size_t kMaxTimeColumns = 4;
constexpr std::size_t kMaxColumns = 32;

// Calls `line` with each line that is neither empty nor a comment, without blanks around it.
template <typename Callback>
void for_each_line(std::string_view text, const Callback& line) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view found = trimmed(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        if (!found.empty() && found.front() != '#') line(found);
    }
}

// Returns a copy in which the blank between a date and its time is a T, so that it is one field.
std::string with_joined_dates(std::string_view line) {
    constexpr std::size_t kDate_chars = 10;
    constexpr std::size_t kWhole_chars = 19;
    std::string joined(line);
    for (std::size_t at = line.find(' '); at != std::string_view::npos; at = line.find(' ', at + 1))
        if (at >= kDate_chars &&
            parse_civil_time(line.substr(at - kDate_chars, kWhole_chars)).has_value())
            joined[at] = 'T';
    return joined;
}

// Returns what separates the fields of a line: semicolons before commas, as commas are the decimal
// points of who uses them.
char separator_of(std::string_view line) {
    for (const char separator : {';', ',', '\t'})
        if (line.find(separator) != std::string_view::npos) return separator;
    return ' ';
}

std::string_view unquoted(std::string_view field) {
    field = trimmed(field);
    const bool is_quoted = field.size() >= 2 && field.front() == '"' && field.back() == '"';
    return is_quoted ? trimmed(field.substr(1, field.size() - 2)) : field;
}

Row fields_of(std::string_view line) {
    const std::string joined = with_joined_dates(line);
    const char separator = separator_of(joined);
    std::string_view rest = joined;
    Row row;
    for (bool more = true; more && row.size() < kMaxColumns;) {
        const std::size_t end = rest.find(separator);
        more = end != std::string_view::npos;
        std::string field(unquoted(rest.substr(0, end)));
        if (separator == ';') std::replace(field.begin(), field.end(), ',', '.');
        const bool is_run = separator == ' ' && field.empty();  // of blanks
        if (!is_run) row.push_back(std::move(field));
        if (more) rest.remove_prefix(end + 1);
    }
    return row;
}

std::string number_of(const std::string& field) {
    const bool is_number = !field.empty() && field.front() >= '0' && field.front() <= '9' &&
                           dive::parse_double(field).has_value();
    return is_number ? field : std::string();
}

// Returns the rows below the headings: those in which one of the first columns is a time.
std::vector<Row> rows_of(std::string_view text) {
    std::vector<Row> rows;
    for_each_line(text, [&](std::string_view line) {
        Row row = fields_of(line);
        const auto end =
            row.begin() + static_cast<std::ptrdiff_t>(std::min(row.size(), kMaxTimeColumns));
        const bool has_time = std::any_of(row.begin(), end, [](const std::string& field) {
            return !number_of(field).empty() || parse_civil_time(field).has_value();
        });
        if (has_time) rows.push_back(std::move(row));
    });
    return rows;
}

std::vector<std::string> column_of(const std::vector<Row>& rows, std::size_t column) {
    std::vector<std::string> fields;
    fields.reserve(rows.size());
    for (const Row& row : rows) {
        if (row.size() <= column) return {};
        fields.push_back(row[column]);
    }
    return fields;
}

TimeTable table_of(const std::vector<Row>& rows,
                   std::size_t column,
                   const std::vector<std::int64_t>& times_ns) {
    TimeTable table;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        table.csv += std::to_string(times_ns[i]);
        for (std::size_t k = column + 1; k < rows[i].size(); ++k) {
            table.csv += ',';
            table.csv += rows[i][k];
        }
        table.csv += '\n';
    }
    table.has_fraction = std::any_of(times_ns.begin(), times_ns.end(), [](std::int64_t time_ns) {
        return time_ns % 1'000'000'000 != 0;
    });
    return table;
}

std::optional<TimeTable> table_by_dates(const std::vector<Row>& rows, std::size_t column) {
    std::vector<std::int64_t> times_ns;
    times_ns.reserve(rows.size());
    for (const std::string& field : column_of(rows, column)) {
        const auto time_ns = parse_civil_time(field);
        if (!time_ns) return std::nullopt;
        times_ns.push_back(*time_ns);
    }
    if (times_ns.empty()) return std::nullopt;
    TimeTable table = table_of(rows, column, times_ns);
    table.unit = "dates";
    return table;
}

std::optional<TimeTable> table_by_numbers(const std::vector<Row>& rows,
                                          std::size_t column,
                                          std::optional<StampUnit> stated) {
    const std::vector<std::string> fields = column_of(rows, column);
    const auto unit = stated && !fields.empty() ? stated : unit_of_stamps(fields);
    if (!unit) return std::nullopt;
    std::vector<std::int64_t> times_ns;
    times_ns.reserve(rows.size());
    for (const std::string& field : fields) {
        const auto time_ns = parse_stamp(field, *unit);
        if (!time_ns) return std::nullopt;
        times_ns.push_back(*time_ns);
    }
    TimeTable table = table_of(rows, column, times_ns);
    table.unit = name_of(*unit);
    return table;
}

}  // namespace

std::optional<TimeTable> convert_time_table(std::string_view text,
                                            std::optional<StampUnit> stated) {
    const std::vector<Row> rows = rows_of(text);
    for (std::size_t column = 0; column < kMaxTimeColumns; ++column) {
        if (auto table = table_by_dates(rows, column)) return table;
        if (auto table = table_by_numbers(rows, column, stated)) return table;
    }
    return std::nullopt;
}

}  // namespace divemesh::recording
