#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/clock_steps.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// A row of a camera's data.csv.
struct CameraRow {
    std::int64_t timestamp_ns = 0;
    std::string file;  // in the dive: "mav0/cam0/data/1403636584763555584.png"
};

// A left and a right image of one moment.
struct FramePair {
    std::int64_t timestamp_ns = 0;  // of the left image
    std::string left;
    std::string right;
};

// Parses a camera's data.csv; bad rows are reported as findings. Rows are in the order of time;
// where the clock was set back they are moved, and `clock` says where.
std::vector<CameraRow> parse_camera_rows(std::string_view text,
                                         const std::string& camera,
                                         FindingLog& findings,
                                         TableClock* clock = nullptr);

// Pairs each left image with the nearest right one, at most half a frame period and 5 ms away.
// Images without a partner are counted in a finding; if there is no pair at all, that is an error.
std::vector<FramePair> match_pairs(const std::vector<CameraRow>& left,
                                   const std::vector<CameraRow>& right,
                                   FindingLog& findings);

}  // namespace divemesh::dive
