#include "worker/dive/coverage.hpp"

#include <algorithm>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/common_clock.hpp"

namespace divemesh::dive {
namespace {

// Checks one table, and empties it if it is of another time than the images.
template <typename Samples>
void check_sensor(const DiveContents& contents,
                  Samples& samples,
                  const std::string& sensor,
                  const std::string& file,
                  FindingLog& findings) {
    if (samples.empty() || contents.frames.pairs.empty()) return;
    const std::int64_t first = contents.frames.pairs.front().timestamp_ns;
    const std::int64_t last = contents.frames.pairs.back().timestamp_ns;
    const std::int64_t begin = samples.front().timestamp_ns;
    const std::int64_t end = samples.back().timestamp_ns;
    const std::string ranges = "it runs from " + std::to_string(begin) + " to " +
                               std::to_string(end) + ", the images from " + std::to_string(first) +
                               " to " + std::to_string(last);
    if (end < first || begin > last) {
        findings.warning(
            sensor + "_no_overlap",
            file,
            file + " does not overlap the images in time, so it is not used: " + ranges,
            "Record both with the same clock. If both began at the same moment, add " +
                std::to_string(first - begin) + " ns to its timestamps.");
        samples.clear();
        return;
    }
    const double covered_s = base::to_s(std::min(end, last) - std::max(begin, first));
    const double dive_s = base::to_s(last - first);
    if (covered_s < 0.98 * dive_s)
        findings.warning(sensor + "_partial",
                         file,
                         file + " covers " + base::fixed(covered_s, 2) + " s of " +
                             base::fixed(dive_s, 2) + " s of images: " + ranges,
                         "Start this sensor before the cameras and stop it after them.");
}

}  // namespace

void check_coverage(DiveContents& contents, FindingLog& findings) {
    const auto check = [&](auto& samples, const std::string& sensor, const char* folder) {
        check_sensor(
            contents, samples, sensor, std::string("mav0/") + folder + "/data.csv", findings);
    };
    check(contents.imu, "imu", "imu0");
    check(contents.ahrs, "ahrs", "ahrs0");
    check(contents.pressure, "pressure", "pressure0");
    check(contents.ground_truth, "ground_truth", "state_groundtruth_estimate0");
    std::vector<std::int64_t> frames_ns;
    for (const FramePair& pair : contents.frames.pairs) frames_ns.push_back(pair.timestamp_ns);
    report_pauses(frames_ns, contents.imu, findings);
}

}  // namespace divemesh::dive
