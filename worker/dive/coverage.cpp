#include "worker/dive/coverage.hpp"

#include <algorithm>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/common_clock.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMaxPeriod_s = 60.0;  // of a sensor

// A unit in which timestamps are written by mistake.
struct TimeUnit {
    std::int64_t in_ns = 1;
    const char* name = "";
};
constexpr TimeUnit kTimeUnits[] = {
    {1'000, "microseconds"}, {1'000'000, "milliseconds"}, {1'000'000'000, "seconds"}};

struct TimeSpan {
    std::int64_t begin_ns = 0;
    std::int64_t end_ns = 0;

    double duration_s() const { return base::to_s(end_ns - begin_ns); }
};

// Returns the time that two spans share, s; negative: the time between them.
double shared_s(const TimeSpan& a, const TimeSpan& b) {
    return base::to_s(std::min(a.end_ns, b.end_ns) - std::max(a.begin_ns, b.begin_ns));
}

// Returns the unit in which the timestamps of a table of so many rows would meet the images;
// nullptr if they do as nanoseconds, or in no unit. Tables and images that both begin at 0 meet in
// any unit: there it has to be as long as the dive, too.
const TimeUnit* other_unit(const TimeSpan& table, std::size_t num_rows, const TimeSpan& images) {
    if (num_rows < 2) return nullptr;
    const bool overlaps = shared_s(table, images) >= 0.0;
    for (const TimeUnit& unit : kTimeUnits) {
        if (table.end_ns > kMaxTimestamp_ns / unit.in_ns) return nullptr;
        const TimeSpan meant{table.begin_ns * unit.in_ns, table.end_ns * unit.in_ns};
        const auto [shorter_s, longer_s] = std::minmax({meant.duration_s(), images.duration_s()});
        const bool is_rare = meant.duration_s() > kMaxPeriod_s * static_cast<double>(num_rows - 1);
        if (!is_rare && shared_s(meant, images) >= 0.5 * (overlaps ? longer_s : shorter_s))
            return &unit;
    }
    return nullptr;
}

// Reports timestamps in another unit, unless their period already told.
void report_unit(const TimeUnit& unit,
                 const std::string& sensor,
                 const std::string& file,
                 const std::string& ranges,
                 FindingLog& findings) {
    const std::string code = sensor + "_timestamp_unit";
    if (std::ranges::any_of(findings.all(), [&](const Finding& f) { return f.code == code; }))
        return;
    findings.error(
        code,
        file,
        "the timestamps meet those of the images only if they are " + std::string(unit.name) +
            ", not nanoseconds: " + ranges,
        "Write timestamps in nanoseconds: these, times " + std::to_string(unit.in_ns) + ".");
}

// Whether a table has to cover all of the images.
enum class Extent { All, Any };

// Checks one table, and empties it if it is of another time than the images.
template <typename Samples>
void check_sensor(const DiveContents& contents,
                  Samples& samples,
                  const std::string& sensor,
                  const std::string& file,
                  Extent extent,
                  FindingLog& findings) {
    if (samples.empty() || contents.frames.pairs.empty()) return;
    const TimeSpan images{contents.frames.pairs.front().timestamp_ns,
                          contents.frames.pairs.back().timestamp_ns};
    const TimeSpan table{samples.front().timestamp_ns, samples.back().timestamp_ns};
    const std::string ranges = "it runs from " + std::to_string(table.begin_ns) + " to " +
                               std::to_string(table.end_ns) + ", the images from " +
                               std::to_string(images.begin_ns) + " to " +
                               std::to_string(images.end_ns);
    if (const TimeUnit* unit = other_unit(table, samples.size(), images)) {
        report_unit(*unit, sensor, file, ranges, findings);
        samples.clear();
        return;
    }
    const double covered_s = shared_s(table, images);
    if (covered_s < 0.0) {
        findings.warning(
            sensor + "_no_overlap",
            file,
            file + " does not overlap the images in time, so it is not used: " + ranges,
            "Record both with the same clock. If both began at the same moment, add " +
                std::to_string(images.begin_ns - table.begin_ns) + " ns to its timestamps.");
        samples.clear();
        return;
    }
    const double dive_s = images.duration_s();
    if (extent == Extent::All && covered_s < 0.98 * dive_s)
        findings.warning(sensor + "_partial",
                         file,
                         file + " covers " + base::fixed(covered_s, 2) + " s of " +
                             base::fixed(dive_s, 2) + " s of images: " + ranges,
                         "Start this sensor before the cameras and stop it after them.");
}

}  // namespace

void check_coverage(DiveContents& contents, FindingLog& findings) {
    const auto check = [&](auto& samples,
                           const std::string& sensor,
                           const std::string& folder,
                           Extent extent = Extent::All) {
        check_sensor(contents, samples, sensor, "mav0/" + folder + "/data.csv", extent, findings);
    };
    check(contents.imu, "imu", "imu0");
    check(contents.ahrs, "ahrs", "ahrs0");
    check(contents.pressure, "pressure", "pressure0");
    check(contents.ground_truth, "ground_truth", "state_groundtruth_estimate0");
    for (types::PositionSource& source : contents.outside.sources)
        check(source.samples, "position", source.name, Extent::Any);
    check(contents.outside.velocities, "velocity", "velocity0", Extent::Any);
    std::erase_if(contents.outside.sources, [](const auto& s) { return s.samples.empty(); });
    std::vector<std::int64_t> frames_ns;
    for (const FramePair& pair : contents.frames.pairs) frames_ns.push_back(pair.timestamp_ns);
    report_pauses(frames_ns, contents.imu, findings);
}

}  // namespace divemesh::dive
