#include "worker/dive/frame_list.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>

#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMinPeriod_s = 1e-3;  // 1000 images a second
constexpr std::int64_t kMaxOffset_ns = 5'000'000;
constexpr double kMinAgreement = 0.9;  // of phases, for one offset to describe them

// Returns the mean of angles between timestamps of a period, and how well they agree (0 to 1).
struct Phase {
    double mean_ns = 0.0;
    double agreement = 0.0;
};

Phase mean_phase(const std::vector<CameraRow>& left,
                 const std::vector<CameraRow>& right,
                 std::int64_t base_ns,
                 std::int64_t period_ns) {
    const double turn = 2.0 * std::numbers::pi / static_cast<double>(period_ns);
    std::complex<double> sum = 0.0;
    std::int64_t num_near = 0;
    for (const CameraRow& row : left) {
        const std::int64_t expected_ns = row.timestamp_ns + base_ns;
        const auto after = std::lower_bound(
            right.begin(), right.end(), expected_ns, [](const CameraRow& r, std::int64_t time) {
                return r.timestamp_ns < time;
            });
        if (after == right.end()) break;
        const std::int64_t difference_ns = after->timestamp_ns - expected_ns;
        if (difference_ns > period_ns) continue;
        sum += std::polar(1.0, turn * static_cast<double>(difference_ns));
        ++num_near;
    }
    if (num_near == 0) return {};
    return {std::arg(sum) / turn, std::abs(sum) / static_cast<double>(num_near)};
}

std::int64_t overlap_ns(const std::vector<CameraRow>& left, const std::vector<CameraRow>& right) {
    return std::min(left.back().timestamp_ns, right.back().timestamp_ns) -
           std::max(left.front().timestamp_ns, right.front().timestamp_ns);
}

std::int64_t duration_ns(const std::vector<CameraRow>& rows) {
    return rows.back().timestamp_ns - rows.front().timestamp_ns;
}

// Returns the path of a listed image below data/, without what leads out of it, as paths of the
// machine that recorded do: complete_image_names() looks for the image. Nullopt if it is no path.
std::optional<std::string> path_in_data(std::string_view listed) {
    if (entry_name_problem(listed).empty()) return std::string(listed);
    std::string path;
    while (!listed.empty()) {
        const std::size_t end = std::min(listed.find_first_of("/\\"), listed.size());
        const std::string_view part = listed.substr(0, end);
        listed.remove_prefix(std::min(end + 1, listed.size()));
        if (part.empty() || part == "." || part == ".." || part.ends_with(':')) continue;
        if (!path.empty()) path += '/';
        path += part;
    }
    return entry_name_problem(path).empty() ? std::optional(path) : std::nullopt;
}

}  // namespace

std::vector<CameraRow> parse_camera_rows(std::string_view text,
                                         const std::string& camera,
                                         FindingLog& findings,
                                         CommonClock* clock) {
    const std::string folder = "mav0/" + camera + "/";
    StampCheck check(camera, folder + "data.csv", findings);
    std::vector<CameraRow> rows;
    std::vector<std::int64_t> lines;
    for_each_csv_row(text, [&](std::int64_t line, std::span<const std::string_view> fields) {
        const auto timestamp = check.accept(line, fields[0]);
        if (!timestamp) return;
        // Some lists have only timestamps, and images that are named by them.
        const std::string_view name = fields.size() < 2 ? fields[0] : fields[1];
        const auto path = path_in_data(name);
        if (!path) return check.count_malformed(line);
        rows.push_back({*timestamp, folder + "data/" + *path});
        lines.push_back(line);
    });
    const TableClock found = check.sort(
        rows,
        lines,
        [](const CameraRow& a, const CameraRow& b) { return a.file == b.file; },
        clock ? clock->known() : TableClock{});
    if (clock) clock->add(check.file(), found);
    check.advise(advise_on_table(text, 1));
    check.report(timestamps_of(rows), kMinPeriod_s);
    return rows;
}

std::int64_t ClockDifference::at(std::int64_t left_ns) const {
    return offset_ns +
           static_cast<std::int64_t>(drift * static_cast<double>(left_ns - reference_ns));
}

std::int64_t common_clock_tolerance_ns(const std::vector<CameraRow>& left) {
    const std::int64_t half_period_ns = median_period_ns(timestamps_of(left)) / 2;
    return half_period_ns > 0 ? std::min(kMaxOffset_ns, half_period_ns) : kMaxOffset_ns;
}

std::vector<FramePair> match_pairs(const std::vector<CameraRow>& left,
                                   const std::vector<CameraRow>& right,
                                   const ClockDifference& difference,
                                   std::int64_t tolerance_ns) {
    std::vector<FramePair> pairs;
    std::vector<std::int64_t> expected_ns;  // by the right clock
    expected_ns.reserve(left.size());
    for (const CameraRow& row : left)
        expected_ns.push_back(row.timestamp_ns + difference.at(row.timestamp_ns));
    const auto distance_ns = [&](std::size_t l, std::size_t r) {
        return std::abs(expected_ns[l] - right[r].timestamp_ns);
    };
    std::size_t r = 0;
    for (std::size_t l = 0; l < left.size() && r < right.size(); ++l) {
        while (r + 1 < right.size() && distance_ns(l, r + 1) <= distance_ns(l, r)) ++r;
        // The right image is nearer to the next left one, so it is kept for that.
        const bool is_wanted_next =
            l + 1 < left.size() && distance_ns(l + 1, r) < distance_ns(l, r);
        if (distance_ns(l, r) > tolerance_ns || is_wanted_next) continue;
        pairs.push_back({left[l].timestamp_ns, left[l].file, right[r].file, right[r].timestamp_ns});
        ++r;
    }
    return pairs;
}

bool agree_in_time(const std::vector<CameraRow>& left, const std::vector<CameraRow>& right) {
    const auto pairs = match_pairs(left, right, {}, common_clock_tolerance_ns(left));
    return pairs.size() * 2 >= std::min(left.size(), right.size());
}

ClockDifference guess_clock_difference(const std::vector<CameraRow>& left,
                                       const std::vector<CameraRow>& right) {
    if (left.empty() || right.empty() || agree_in_time(left, right)) return {};
    ClockDifference difference;
    difference.reference_ns = left.front().timestamp_ns;
    const bool ran_together =
        overlap_ns(left, right) * 2 > std::min(duration_ns(left), duration_ns(right));
    if (!ran_together)
        difference.offset_ns = right.front().timestamp_ns - left.front().timestamp_ns;
    const std::int64_t period_ns = median_period_ns(timestamps_of(left));
    if (period_ns == 0) return difference;
    const Phase phase = mean_phase(left, right, difference.offset_ns, period_ns);
    if (phase.agreement > kMinAgreement)
        difference.offset_ns += static_cast<std::int64_t>(std::llround(phase.mean_ns));
    return difference;
}

}  // namespace divemesh::dive
