#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/common_clock.hpp"
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
    std::int64_t right_ns = 0;  // of the right image, by its own clock
};

// Parses a camera's data.csv; bad rows are reported as findings. Rows are in the order of time;
// where the clock was set back they are moved, as far as it is known with the shifts of `clock`, to
// which the table is added.
std::vector<CameraRow> parse_camera_rows(std::string_view text,
                                         const std::string& camera,
                                         FindingLog& findings,
                                         CommonClock* clock = nullptr);

// How the clock of the right camera differs from that of the left one.
struct ClockDifference {
    std::int64_t offset_ns = 0;     // right - left, at `reference_ns`
    double drift = 0.0;             // by which it grows, in seconds a second
    std::int64_t reference_ns = 0;  // by the left clock

    bool is_zero() const { return offset_ns == 0 && drift == 0.0; }
    std::int64_t at(std::int64_t left_ns) const;
};

// Pairs each left image with the nearest right one, at most `tolerance_ns` away once the difference
// of the clocks is taken off.
std::vector<FramePair> match_pairs(const std::vector<CameraRow>& left,
                                   const std::vector<CameraRow>& right,
                                   const ClockDifference& difference,
                                   std::int64_t tolerance_ns);

// Returns the tolerance for cameras on one clock: half a frame period, at most 5 ms.
std::int64_t common_clock_tolerance_ns(const std::vector<CameraRow>& left);

// Returns true if at least half of the images have a partner within that tolerance.
bool agree_in_time(const std::vector<CameraRow>& left, const std::vector<CameraRow>& right);

// Returns the difference of the clocks by the timestamps alone: 0 if they agree in time.
// Otherwise the offset that brings timestamps of both cameras nearest to each other: by less than a
// frame period if both ran at the same time, else from the first image of one to the first of the
// other.
ClockDifference guess_clock_difference(const std::vector<CameraRow>& left,
                                       const std::vector<CameraRow>& right);

}  // namespace divemesh::dive
