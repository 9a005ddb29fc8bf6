#include "worker/dive/frame_list.hpp"

#include <algorithm>
#include <cstdlib>

#include "worker/base/text.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMinPeriod_s = 1e-3;  // 1000 images a second
constexpr std::int64_t kMaxOffset_ns = 5'000'000;
constexpr std::int64_t kReportedOffset_ns = 1'000'000;

std::vector<std::int64_t> stamps(const std::vector<CameraRow>& rows) {
    std::vector<std::int64_t> result;
    result.reserve(rows.size());
    for (const CameraRow& row : rows) result.push_back(row.timestamp_ns);
    return result;
}

std::string range(const std::vector<CameraRow>& rows) {
    return std::to_string(rows.front().timestamp_ns) + " to " +
           std::to_string(rows.back().timestamp_ns);
}

void report_pairs(const std::vector<CameraRow>& left,
                  const std::vector<CameraRow>& right,
                  const std::vector<FramePair>& pairs,
                  std::int64_t max_offset_ns,
                  FindingLog& findings) {
    if (pairs.empty())
        return findings.error("left_right_no_overlap",
                              "mav0/cam1/data.csv",
                              "no left image has a right image of the same time: left " +
                                  range(left) + ", right " + range(right),
                              "Record both cameras with the same clock.");
    const std::size_t num_left = left.size() - pairs.size();
    const std::size_t num_right = right.size() - pairs.size();
    if (num_left + num_right > 0)
        findings.warning("frames_unmatched",
                         "mav0/cam1/data.csv",
                         std::to_string(num_left) + " left and " + std::to_string(num_right) +
                             " right images have no partner and are ignored",
                         "Trigger both cameras together.");
    if (max_offset_ns > kReportedOffset_ns)
        findings.warning("frames_unsynchronised",
                         "mav0/cam1/data.csv",
                         "left and right images are up to " +
                             base::fixed(static_cast<double>(max_offset_ns) * 1e-6, 2) +
                             " ms apart",
                         "Trigger both cameras together: at 0.3 m/s, 5 ms are 1.5 mm of baseline.");
}

}  // namespace

std::vector<CameraRow> parse_camera_rows(std::string_view text,
                                         const std::string& camera,
                                         FindingLog& findings) {
    const std::string folder = "mav0/" + camera + "/";
    StampCheck check(camera, folder + "data.csv", findings);
    std::vector<CameraRow> rows;
    for_each_csv_row(text, [&](std::int64_t line, std::span<const std::string_view> fields) {
        const auto timestamp = check.accept(line, fields[0]);
        if (!timestamp) return;
        if (fields.size() < 2 || !entry_name_problem(fields[1]).empty())
            return check.count_malformed(line);
        rows.push_back({*timestamp, folder + "data/" + std::string(fields[1])});
        check.keep(line);
    });
    check.finish(rows, kMinPeriod_s, SetBack::Keep);
    return rows;
}

std::vector<FramePair> match_pairs(const std::vector<CameraRow>& left,
                                   const std::vector<CameraRow>& right,
                                   FindingLog& findings) {
    std::vector<FramePair> pairs;
    if (left.empty() || right.empty()) return pairs;
    const std::int64_t half_period_ns = median_period_ns(stamps(left)) / 2;
    const std::int64_t tolerance_ns =
        half_period_ns > 0 ? std::min(kMaxOffset_ns, half_period_ns) : kMaxOffset_ns;
    const auto offset_ns = [&](std::size_t l, std::size_t r) {
        return std::abs(left[l].timestamp_ns - right[r].timestamp_ns);
    };
    std::int64_t max_offset_ns = 0;
    std::size_t r = 0;
    for (std::size_t l = 0; l < left.size() && r < right.size(); ++l) {
        while (r + 1 < right.size() && offset_ns(l, r + 1) <= offset_ns(l, r)) ++r;
        // The right image is nearer to the next left one, so it is kept for that.
        const bool is_wanted_next = l + 1 < left.size() && offset_ns(l + 1, r) < offset_ns(l, r);
        if (offset_ns(l, r) > tolerance_ns || is_wanted_next) continue;
        max_offset_ns = std::max(max_offset_ns, offset_ns(l, r));
        pairs.push_back({left[l].timestamp_ns, left[l].file, right[r].file});
        ++r;
    }
    report_pairs(left, right, pairs, max_offset_ns, findings);
    return pairs;
}

}  // namespace divemesh::dive
