#include "worker/recording/import_video.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "schemas/error.hpp"
#include "worker/base/parallel.hpp"
#include "worker/base/part_of.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/recording/imu_clock.hpp"
#include "worker/recording/input_file.hpp"
#include "worker/recording/provenance.hpp"
#include "worker/recording/read_video.hpp"
#include "worker/video/chapter_files.hpp"
#include "worker/video/find_offset.hpp"
#include "worker/video/gpmf_gps.hpp"
#include "worker/video/gpmf_imu.hpp"

namespace divemesh::recording {
namespace {

constexpr double kMaxRate_hz = 1000.0;
constexpr double kMaxOffset_s = 1e6;
constexpr int kThreads = 0;                                      // as many as there are cores
constexpr std::int64_t kBatch_bytes = std::int64_t{256} << 20U;  // of pixels in memory
constexpr std::size_t kMaxBatch = 64;                            // pairs
constexpr double kReportedUnpaired_s = 1.0;
constexpr double kIndexed = 0.1;  // parts of the progress
constexpr double kAligned = 0.2;

[[noreturn]] void fail(ErrorCode code, const std::string& what) { throw Error(code, what); }

std::string size_text(std::int64_t width_px, std::int64_t height_px) {
    std::string text = std::to_string(width_px);
    text += " x ";
    text += std::to_string(height_px);
    return text + " px";
}

}  // namespace

bool is_video_file(const std::filesystem::path& path) {
    constexpr std::int64_t kHead_bytes = 12;
    return video::is_video(InputFile(path).read(0, kHead_bytes));
}

VideoImport::VideoImport(VideoImportOptions options, const base::ProgressCallback& progress)
    : options_(std::move(options)) {
    check_options();
    const double part = kIndexed / static_cast<double>(options_.videos.size());
    for (const auto& path : options_.videos) {
        const double begin = part * static_cast<double>(videos_.size());
        videos_.push_back(
            read_video(path, findings_, base::part_of(progress, begin, begin + part)));
    }
    rig_ = options_.is_uncalibrated
               ? uncalibrated_rig(image_size(videos_.front()), image_size(videos_.back()))
               : read_rig(options_.calibration, findings_, hints());
    check_sizes();
}

RigHints VideoImport::hints() const {
    const ImageSize size = image_size(videos_.front());
    RigHints hints;
    hints.resolution = {static_cast<double>(size.width_px), static_cast<double>(size.height_px)};
    hints.metres_per_unit = options_.metres_per_unit;
    return hints;
}

void VideoImport::check_options() const {
    const bool is_one_file = options_.layout != VideoLayout::TwoFiles;
    if (options_.videos.size() != (is_one_file ? 1U : 2U))
        fail(ErrorCode::InvalidArgument,
             is_one_file ? "--layout is of one video that holds both cameras: give one file"
                         : "give two videos, of the left and of the right camera, or one that "
                           "holds both with --layout side-by-side or over-under");
    if (options_.calibration.empty() && !options_.is_uncalibrated)
        fail(ErrorCode::InvalidArgument,
             std::string("a video states no calibration: ") + kStateCalibration);
    if (!options_.imu.empty() && options_.imu != "none")
        fail(ErrorCode::InvalidArgument, "a video has no topics: --imu can only be none");
    if (!(options_.rate_hz > 0.0) || options_.rate_hz > kMaxRate_hz)
        fail(ErrorCode::InvalidArgument, "--rate is pairs a second, above 0 and up to 1000");
    if (options_.offset_s && !(std::abs(*options_.offset_s) <= kMaxOffset_s))
        fail(ErrorCode::InvalidArgument, "--offset is in seconds, up to a million either way");
    if (options_.offset_s && is_one_file)
        fail(ErrorCode::InvalidArgument,
             "--offset is between two videos: both cameras of this one have the same clock");
    if (!is_one_file && video::are_chapters_of_one(options_.videos[0], options_.videos[1]))
        fail(ErrorCode::InvalidArgument,
             "both videos are chapters of one recording by their names, not of a left and a right "
             "camera: give the first chapter of each camera; those after it are joined");
}

// Returns the size of the images of one camera in a video.
ImageSize VideoImport::image_size(const video::IndexedVideo& video) const {
    ImageSize size{video.index.traits.upright_width_px(), video.index.traits.upright_height_px()};
    if (options_.layout == VideoLayout::SideBySide) size.width_px /= 2;
    if (options_.layout == VideoLayout::OverUnder) size.height_px /= 2;
    return size;
}

// Checks that images are of the size that the calibration is for.
void VideoImport::check_sizes() const {
    for (const auto& [side, calibrated] :
         {std::pair("left", &rig_.cam0.camera), std::pair("right", &rig_.cam1.camera)}) {
        const auto& video = calibrated == &rig_.cam0.camera ? videos_.front() : videos_.back();
        const ImageSize size = image_size(video);
        if (size.width_px == calibrated->width_px && size.height_px == calibrated->height_px)
            continue;
        fail(ErrorCode::InvalidArgument,
             video.name() + " has " + side + " images of " +
                 size_text(size.width_px, size.height_px) + ", the calibration is for " +
                 size_text(calibrated->width_px, calibrated->height_px) +
                 ": state that of these images by --calibration");
    }
}

ImportCounts VideoImport::write(const base::ProgressCallback& progress) {
    DiveWriter writer(options_.out, options_.durability);
    const auto clock = find_clock(base::part_of(progress, kIndexed, kAligned));
    const auto pairs = plan(clock);
    report_gaps(pairs, clock);
    write_pairs(pairs, clock, writer, base::part_of(progress, kAligned, 1.0));
    if (writer.num_images(Side::Left) == 0)
        fail(ErrorCode::BadData, "no image of the videos can be decoded: copy them again");
    write_imu(clock, writer);
    const auto position = find_position();
    Provenance provenance{.name = options_.videos.front().stem().string(),
                          .files = {},
                          .findings = findings(),
                          .position = position};
    for (const auto& video : videos_)
        for (const video::VideoPart& part : video.parts)
            provenance.files.push_back(imported_file(part.path.filename().string(), {part.path}));
    if (options_.naming == Naming::Unnamed) remove_names(provenance);
    writer.commit(rig_, provenance);
    return {writer.num_images(Side::Left), writer.num_images(Side::Right), writer.num_imu(), 0};
}

video::ClockOffset VideoImport::find_clock(const base::ProgressCallback& progress) {
    if (options_.layout != VideoLayout::TwoFiles) return {};
    return video::find_offset(videos_[0], videos_[1], options_.offset_s, findings_, progress);
}

std::vector<video::PlannedPair> VideoImport::plan(const video::ClockOffset& clock) {
    const auto& left_ns = videos_.front().index.stamps_ns;
    const auto& right_ns = videos_.back().index.stamps_ns;
    auto pairs = video::plan_pairs(left_ns, right_ns, clock, options_.rate_hz);
    if (pairs.empty())
        fail(ErrorCode::BadData,
             "the videos have no frames of the same time: the right one is from " +
                 base::fixed(base::to_s(clock.left_ns(right_ns.front())), 1) + " to " +
                 base::fixed(base::to_s(clock.left_ns(right_ns.back())), 1) +
                 " s on the clock of the left one, which ends at " +
                 base::fixed(base::to_s(left_ns.back()), 1) +
                 " s: give videos of the same dive, or state --offset");
    const double unpaired_s =
        base::to_s(left_ns.back() - left_ns.front() - pairs.back().left_ns + pairs.front().left_ns);
    if (unpaired_s > kReportedUnpaired_s && options_.layout == VideoLayout::TwoFiles)
        findings_.info("video_unpaired",
                       videos_.front().name(),
                       base::fixed(unpaired_s, 1) +
                           " s of this video are before or after the other one, and are left out");
    return pairs;
}

// States how far apart the frames of a pair are.
void VideoImport::report_gaps(const std::vector<video::PlannedPair>& pairs,
                              const video::ClockOffset& clock) {
    if (options_.layout != VideoLayout::TwoFiles) return;
    const video::PairTimes between = video::times_between(pairs, clock);
    findings_.info("video_gaps",
                   videos_.back().name(),
                   "the frames of a pair are " + base::fixed(1e3 * between.median_s, 1) +
                       " ms apart in the median, and " + base::fixed(1e3 * between.max_s, 1) +
                       " ms at most");
}

// Returns what is added to stamps of the left video: when it was created, if it says so.
std::int64_t VideoImport::start_ns() const {
    constexpr std::int64_t kUnknownStart_ns = 1'000'000'000;
    const auto& index = videos_.front().index;
    const std::int64_t before_ns = std::max<std::int64_t>(-index.stamps_ns.front(), 0);
    return index.traits.creation_ns.value_or(kUnknownStart_ns) + before_ns;
}

void VideoImport::write_pairs(const std::vector<video::PlannedPair>& pairs,
                              const video::ClockOffset& clock,
                              DiveWriter& writer,
                              const base::ProgressCallback& progress) {
    PairedVideo paired(videos_, options_.layout, pairs);
    std::vector<VideoPair> batch;
    const std::int64_t pair_bytes =
        3 * (rig_.cam0.camera.width_px * std::int64_t{rig_.cam0.camera.height_px} +
             rig_.cam1.camera.width_px * std::int64_t{rig_.cam1.camera.height_px});
    const std::size_t batch_size =
        std::clamp<std::size_t>(static_cast<std::size_t>(kBatch_bytes / pair_bytes), 1, kMaxBatch);
    std::int64_t num_damaged = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        progress({"import", static_cast<double>(i) / static_cast<double>(pairs.size())});
        auto pair = paired.at(pairs[i]);
        if (pair) batch.push_back(std::move(*pair));
        if (!pair) ++num_damaged;
        if (batch.size() < batch_size) continue;
        write_batch(batch, clock, writer);
        batch.clear();
    }
    write_batch(batch, clock, writer);
    if (num_damaged > 0)
        findings_.warning("frames_damaged",
                          videos_.front().name(),
                          std::to_string(num_damaged) + " of " + std::to_string(pairs.size()) +
                              " pairs have a frame that cannot be decoded, and are left out",
                          "Copy the videos again.");
}

// Writes pairs with the times of their frames by the left clock.
void VideoImport::write_batch(const std::vector<VideoPair>& batch,
                              const video::ClockOffset& clock,
                              DiveWriter& writer) const {
    std::vector<ImageFile> files(2 * batch.size());
    base::for_each_index(kThreads, files.size(), [&](std::size_t i) {
        files[i] = image_file(i % 2 == 0 ? batch[i / 2].left : batch[i / 2].right);
    });
    const bool is_one_file = options_.layout != VideoLayout::TwoFiles;
    for (std::size_t i = 0; i < batch.size(); ++i) {
        const std::int64_t left_ns = start_ns() + batch[i].times.left_ns;
        const std::int64_t right_ns =
            is_one_file ? left_ns : start_ns() + clock.left_ns(batch[i].times.right_ns);
        writer.add_image(Side::Left, left_ns, files[2 * i]);
        writer.add_image(Side::Right, right_ns, files[2 * i + 1]);
    }
}

// Writes the gyroscope and accelerometer of the left camera, or of the right one if it alone has
// them.
void VideoImport::write_imu(const video::ClockOffset& clock, DiveWriter& writer) {
    const bool is_left = videos_.front().index.traits.has_gpmf;
    const auto& video = is_left ? videos_.front() : videos_.back();
    if (!video.index.traits.has_gpmf || options_.imu == "none" || options_.is_uncalibrated) return;
    const video::GpmfImu imu = video::imu_of(video.index.gpmf);
    if (imu.is_damaged)
        findings_.warning("telemetry_damaged",
                          video.name(),
                          "a part of the telemetry is damaged, and is left out",
                          "Copy the video again.");
    if (imu.samples.empty()) return;
    if (!rig_.imu_yaml)
        return findings_.warning(
            "imu_left_out",
            video.name(),
            "the IMU is left out: where it is relative to the cameras is not known",
            "State it by --calibration: T_BS of both cameras relative to the IMU.");
    for (types::ImuSample sample : imu.samples) {
        if (!is_left) sample.timestamp_ns = clock.left_ns(sample.timestamp_ns);
        sample.timestamp_ns += start_ns();
        if (sample.timestamp_ns > 0) writer.add_imu(sample);
    }
    apply_imu_shift(rig_, writer, findings_);
}

// Returns where the left camera was by the GPS of its telemetry, or the right one if it alone
// knows.
std::optional<types::GeographicPosition> VideoImport::find_position() {
    constexpr int kDecimals = 6;  // of degrees: a tenth of a metre
    for (const video::IndexedVideo& video : videos_) {
        const auto found = video::gps_position_of(video.index.gpmf);
        if (!found) continue;
        findings_.info("position_by_gps",
                       video.name(),
                       "the position of the dive is latitude " +
                           base::fixed(found->position.latitude_deg, kDecimals) + ", longitude " +
                           base::fixed(found->position.longitude_deg, kDecimals) +
                           ", the median of " + std::to_string(found->num_fixes) +
                           " fixes by the camera's GPS at the surface; half of them are within " +
                           base::fixed(found->scatter_m, 1) + " m of it, 95 % within " +
                           base::fixed(found->spread_m, 1) + " m");
        return found->position;
    }
    return std::nullopt;
}

}  // namespace divemesh::recording
