#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "worker/dive/common_clock.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/dive/table_advice.hpp"

namespace divemesh::dive {

// Above every sensor's range in any unit; squares stay finite.
inline constexpr double kMaxReading = 1e9;
// 50 kHz; milli- and microseconds give far shorter periods.
inline constexpr double kMinPeriod_s = 2e-5;

// What a field without a number means.
enum class EmptyFields { Malformed, Zero };

// Returns the number in a field; nullopt if there is none.
inline std::optional<double> value_at(std::span<const std::string_view> fields,
                                      std::size_t index,
                                      EmptyFields empty) {
    if (index >= fields.size()) return std::nullopt;
    if (empty == EmptyFields::Zero && fields[index].empty()) return 0.0;
    return parse_double(fields[index]);
}

// Reads rows of a timestamp and N numbers, in the order of time. `use` turns them into a sample, or
// returns nullopt if the row is malformed; `is_same` tells whether two samples hold the same
// values. `check` reports what was wrong with the rows.
template <std::size_t N, typename Sample, typename Use, typename IsSame>
std::vector<Sample> read_samples(std::string_view text,
                                 StampCheck& check,
                                 CommonClock* clock,
                                 const Use& use,
                                 const IsSame& is_same,
                                 EmptyFields empty = EmptyFields::Malformed) {
    std::vector<Sample> samples;
    std::vector<std::int64_t> lines;
    for_each_csv_row(text, [&](std::int64_t line, std::span<const std::string_view> fields) {
        const auto timestamp = check.accept(line, fields[0]);
        if (!timestamp) return;
        std::array<double, N> values{};
        for (std::size_t i = 0; i < N; ++i) {
            const auto value = value_at(fields, i + 1, empty);
            if (!value) return check.count_malformed(line);
            values[i] = *value;
        }
        if (!std::all_of(values.begin(), values.end(), [](double value) {
                return std::abs(value) <= kMaxReading;  // false for NaN
            }))
            return check.count_not_finite(line);
        const std::optional<Sample> sample = use(*timestamp, values);
        if (!sample) return check.count_malformed(line);
        samples.push_back(*sample);
        lines.push_back(line);
    });
    const TableClock found =
        check.sort(samples, lines, is_same, clock ? clock->known() : TableClock{});
    if (clock) clock->add(check.file(), found);
    check.advise(advise_on_table(text, N));
    check.report(timestamps_of(samples), kMinPeriod_s);
    return samples;
}

}  // namespace divemesh::dive
