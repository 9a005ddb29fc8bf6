#include "tests/bench/dive_change.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "tests/bench/frame_overlap.hpp"
#include "tests/bench/images.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/dive/dive.hpp"
#include "worker/simulator/dive_files.hpp"
#include "worker/simulator/stated_rig.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kLate_ns = 250e6;
// An IMU of a phone or an action camera.
constexpr types::ImuNoise kMems{.gyroscope_noise_density = 2e-3,
                                .gyroscope_random_walk = 1e-4,
                                .accelerometer_noise_density = 2e-2,
                                .accelerometer_random_walk = 3e-3};
constexpr std::int64_t kShortFailure_ns = 4'000'000'000;
constexpr std::int64_t kClockJump_ns = 200'000'000;
constexpr double kJump_rad_s = 0.06;
constexpr double kGamma = 2.2;  // of the tone curve of simulated cameras

// A frame of the changed dive: when it was taken, and the frame whose images it shows.
struct KeptFrame {
    int taken = 0;
    int shown = 0;
};

std::vector<int> every_frame(int num_frames, int step) {
    std::vector<int> frames;
    for (int i = 0; i < num_frames; i += step) frames.push_back(i);
    return frames;
}

void drop_share(std::vector<int>& frames, double share, std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x64726f70ULL));
    std::erase_if(frames, [&](int) { return random.uniform(0.0, 1.0) < share; });
}

std::vector<KeptFrame> with_doubled(const std::vector<int>& frames,
                                    double share,
                                    std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x747769636557ULL));
    std::vector<KeptFrame> kept;
    for (const int frame : frames) {
        const bool doubled = !kept.empty() && random.uniform(0.0, 1.0) < share;
        kept.push_back({frame, doubled ? kept.back().shown : frame});
    }
    return kept;
}

std::int64_t stamp_ns(const fs::path& image) { return std::stoll(image.stem().string()); }

void cut_gap(std::vector<int>& frames, const PairFiles& pairs, double gap_s) {
    const std::int64_t middle_ns =
        std::midpoint(stamp_ns(pairs.front().first), stamp_ns(pairs.back().first));
    std::erase_if(frames, [&](int frame) {
        const auto index = static_cast<std::size_t>(frame);
        return std::abs(1e-9 * static_cast<double>(stamp_ns(pairs[index].first) - middle_ns)) <
               0.5 * gap_s;
    });
}

std::vector<KeptFrame> kept_frames(const fs::path& dive,
                                   const PairFiles& pairs,
                                   const DiveChange& change,
                                   std::uint64_t seed) {
    std::vector<int> frames = change.overlap > 0.0
                                  ? FrameOverlap(dive).spaced_by(change.overlap)
                                  : every_frame(static_cast<int>(pairs.size()), change.keep_every);
    if (change.dropped_share > 0.0) drop_share(frames, change.dropped_share, seed);
    if (change.gap_s > 0.0) cut_gap(frames, pairs, change.gap_s);
    return with_doubled(frames, change.doubled_share, seed);
}

// Which frames only see water: those taken within the stretch.
class BlueStretch {
public:
    BlueStretch(const PairFiles& pairs, const DiveChange& change)
        : duration_ns_(static_cast<std::int64_t>(1e9 * change.blue_s)) {
        const std::int64_t first_ns = stamp_ns(pairs.front().first);
        const std::int64_t last_ns = stamp_ns(pairs.back().first);
        begin_ns_ =
            first_ns + std::llround(change.blue_at_share * static_cast<double>(last_ns - first_ns));
    }
    bool contains(std::int64_t time_ns) const {
        return time_ns >= begin_ns_ && time_ns < begin_ns_ + duration_ns_;
    }

private:
    std::int64_t begin_ns_ = 0;
    std::int64_t duration_ns_;
};

// The images that a dive shows: its own, or those of only water.
PairFiles shown_pairs(const DiveSources& sources,
                      const PairFiles& pairs,
                      const DiveChange& change) {
    if (change.blue_s <= 0.0) return pairs;
    const PairFiles blue_pairs = pair_files(sources.blue);
    const BlueStretch blue(pairs, change);
    PairFiles shown = pairs;
    for (std::size_t i = 0; i < pairs.size(); ++i)
        if (blue.contains(stamp_ns(pairs[i].first))) shown[i] = blue_pairs.at(i);
    return shown;
}

void link_or_copy(const fs::path& from, const fs::path& to) {
    std::error_code failure;
    fs::create_hard_link(from, to, failure);
    if (failure) fs::copy_file(from, to);
}

// Linear light times `factor`, through the tone curve.
void write_exposed(const fs::path& from, double factor, const fs::path& to) {
    cv::Mat image = cv::imread(from.string(), cv::IMREAD_UNCHANGED);
    image.convertTo(image, -1, std::pow(factor, 1.0 / kGamma));
    if (!cv::imwrite(to.string(), image)) throw std::runtime_error("cannot write " + to.string());
}

std::vector<simulator::ImageName> write_images(const PairFiles& pairs,
                                               const std::vector<KeptFrame>& frames,
                                               double right_exposure,
                                               const fs::path& mav0) {
    for (const char* camera : {"cam0", "cam1"}) fs::create_directories(mav0 / camera / "data");
    std::vector<simulator::ImageName> names;
    for (const KeptFrame& frame : frames) {
        const fs::path name = pairs[static_cast<std::size_t>(frame.taken)].first.filename();
        const auto& [left, right] = pairs[static_cast<std::size_t>(frame.shown)];
        link_or_copy(left, mav0 / "cam0" / "data" / name);
        const fs::path to = mav0 / "cam1" / "data" / name;
        if (right_exposure == 1.0)
            link_or_copy(right, to);
        else
            write_exposed(right, right_exposure, to);
        names.push_back({stamp_ns(name), name.string()});
    }
    return names;
}

std::vector<simulator::ImuRecord> records_of(const dive::Dive& dive) {
    std::vector<simulator::ImuRecord> records;
    for (const types::ImuSample& sample : dive.imu()) records.push_back({.sample = sample});
    return records;
}

Eigen::Vector3d gaussian3(base::RandomRow& random) {
    const double x = random.gaussian();
    const double y = random.gaussian();
    return {x, y, random.gaussian()};
}

void add_noise(std::vector<simulator::ImuRecord>& records,
               const types::ImuNoise& noise,
               std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x6d656d73ULL));
    const double white = std::sqrt(simulator::kImuRateHz);
    Eigen::Vector3d gyroscope_bias = 0.02 * gaussian3(random);      // rad/s
    Eigen::Vector3d accelerometer_bias = 0.15 * gaussian3(random);  // m/s^2
    for (auto& [sample, truth, unused_gyroscope, unused_accelerometer] : records) {
        sample.angular_velocity_imu +=
            gyroscope_bias + white * noise.gyroscope_noise_density * gaussian3(random);
        sample.acceleration_imu +=
            accelerometer_bias + white * noise.accelerometer_noise_density * gaussian3(random);
        gyroscope_bias += noise.gyroscope_random_walk / white * gaussian3(random);
        accelerometer_bias += noise.accelerometer_random_walk / white * gaussian3(random);
    }
}

types::ImuNoise times(const types::ImuNoise& noise, double factor) {
    return {.gyroscope_noise_density = factor * noise.gyroscope_noise_density,
            .gyroscope_random_walk = factor * noise.gyroscope_random_walk,
            .accelerometer_noise_density = factor * noise.accelerometer_noise_density,
            .accelerometer_random_walk = factor * noise.accelerometer_random_walk};
}

void mirror_y(std::vector<simulator::ImuRecord>& records) {
    for (simulator::ImuRecord& record : records) {
        record.sample.angular_velocity_imu.y() *= -1.0;
        record.sample.acceleration_imu.y() *= -1.0;
    }
}

// Changes the samples from two fifths of the dive on, or for four seconds from there.
void fail(std::vector<simulator::ImuRecord>& records, DiveChange::Imu kind) {
    if (records.empty()) return;
    const std::int64_t start_ns = records.front().sample.timestamp_ns;
    const std::int64_t from_ns = start_ns + (records.back().sample.timestamp_ns - start_ns) * 2 / 5;
    for (std::size_t i = 0; i < records.size(); ++i) {
        types::ImuSample& sample = records[i].sample;
        const std::int64_t since_ns = sample.timestamp_ns - from_ns;
        if (since_ns < 0) continue;
        const bool is_short = since_ns < kShortFailure_ns;
        if (kind == DiveChange::Imu::GyroscopeStops && is_short)
            sample.angular_velocity_imu.setConstant(i % 2 == 0 ? 1e-4 : -1e-4);
        if (kind == DiveChange::Imu::ForcesDouble && is_short) sample.acceleration_imu *= 2.0;
        if (kind == DiveChange::Imu::BiasJumps)
            sample.angular_velocity_imu += kJump_rad_s * Eigen::Vector3d(0.8, -0.6, 0.0);
        if (kind == DiveChange::Imu::ClockJumps) sample.timestamp_ns += kClockJump_ns;
    }
}

void write_imu(const dive::Dive& dive,
               const fs::path& other,
               const DiveChange& change,
               std::uint64_t seed,
               std::int64_t late_ns,
               const fs::path& folder) {
    if (change.imu == DiveChange::Imu::None) return;
    const TemporaryFolder scratch;
    auto records = change.imu == DiveChange::Imu::OtherDive
                       ? records_of(*dive::Dive::open(other, scratch.path()))
                       : records_of(dive);
    types::ImuNoise stated = *dive.rig().imu_noise;
    switch (change.imu) {
        case DiveChange::Imu::Mems:
            add_noise(records, kMems, seed);
            stated = kMems;
            break;
        case DiveChange::Imu::NoiseTooSmall: stated = times(stated, 0.01); break;
        case DiveChange::Imu::NoiseTooLarge: stated = times(stated, 100.0); break;
        case DiveChange::Imu::Late: late_ns += static_cast<std::int64_t>(kLate_ns); break;
        case DiveChange::Imu::Mirrored: mirror_y(records); break;
        default: fail(records, change.imu); break;
    }
    for (simulator::ImuRecord& record : records) record.sample.timestamp_ns += late_ns;
    simulator::write_imu_files(folder, stated, records);
}

void copy_rest(const fs::path& dive, const fs::path& out) {
    for (const char* sensor : {"state_groundtruth_estimate0", "pressure0"})
        if (fs::exists(dive / "mav0" / sensor))
            fs::copy(dive / "mav0" / sensor, out / "mav0" / sensor, fs::copy_options::recursive);
    fs::copy_file(dive / "dive.json", out / "dive.json");
}

}  // namespace

void write_changed(const DiveSources& sources,
                   const DiveChange& change,
                   std::uint64_t seed,
                   const fs::path& out) {
    const PairFiles pairs = pair_files(sources.dive);
    const auto frames = kept_frames(sources.dive, pairs, change, seed);
    const auto names = write_images(
        shown_pairs(sources, pairs, change), frames, change.right_exposure, out / "mav0");
    const TemporaryFolder scratch;
    const auto opened = dive::Dive::open(sources.dive, scratch.path());
    simulator::StatedRig stated =
        simulator::draw_calibration_error(opened->rig(), change.calibration_error, seed);
    if (change.vertical_misalignment_px != 0.0)
        stated.rig = simulator::pitch_right_camera(stated.rig, change.vertical_misalignment_px);
    const double rate_hz =
        1e9 * static_cast<double>(std::max<std::size_t>(1, names.size() - 1)) /
        static_cast<double>(names.back().timestamp_ns - names.front().timestamp_ns + 1);
    simulator::write_camera_files(
        out / "mav0" / "cam0", stated.rig.cam0, stated.rig.T_imu_cam0, rate_hz, names);
    simulator::write_camera_files(
        out / "mav0" / "cam1", stated.rig.cam1, stated.rig.T_imu_cam1, rate_hz, names);
    write_imu(
        *opened, sources.other, change, seed, stated.imu_clock_offset_ns, out / "mav0" / "imu0");
    copy_rest(sources.dive, out);
}

}  // namespace divemesh::bench
