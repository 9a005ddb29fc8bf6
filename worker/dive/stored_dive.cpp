#include "worker/dive/stored_dive.hpp"

#include <chrono>
#include <utility>

#include "worker/base/seconds.hpp"
#include "worker/dive/coverage.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/gravity_check.hpp"
#include "worker/dive/image_checks.hpp"
#include "worker/dive/image_size.hpp"
#include "worker/dive/motion_check.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/io/ply.hpp"

namespace divemesh::dive {
namespace {

constexpr int kPrefetchedPairs = 3;
constexpr int kImagesProbed = 5;
constexpr int kNumFirstPairs = 9;
constexpr const char* kReferenceMesh = "reference.ply";
constexpr const char* kSceneMesh = "scene.ply";

// Returns a callback that passes on at most one call per 50 ms.
base::ProgressCallback throttled(const base::ProgressCallback& progress) {
    using Clock = std::chrono::steady_clock;
    return [&progress, next = Clock::time_point()](const Progress& state) mutable {
        const auto now = Clock::now();
        if (now < next) return;
        next = now + std::chrono::milliseconds(50);
        progress(state);
    };
}

std::string remedy_for(const std::string& code) {
    if (code == "image_size")
        return "State the calibration of images of this size in sensor.yaml, or record with the "
               "resolution of the calibration.";
    if (code == "image_missing") return "Copy the recording again and compare the number of files.";
    if (code == "image_repeated")
        return "Record at a constant frame rate, that of the camera, and check its connection.";
    return "The dive runs without this frame. If you need it, copy or convert the image.";
}

// Returns whether IMU or AHRS cover the right camera's time and not the left one's.
bool follow_right_clock(const DiveContents& contents) {
    const std::vector<std::int64_t> sensor_ns =
        contents.imu.empty() ? timestamps_of(contents.ahrs) : timestamps_of(contents.imu);
    if (sensor_ns.empty() || contents.frames.pairs.empty()) return false;
    const FramePair& first = contents.frames.pairs.front();
    const FramePair& last = contents.frames.pairs.back();
    const auto covers = [&](std::int64_t begin_ns, std::int64_t end_ns) {
        return sensor_ns.front() <= end_ns && sensor_ns.back() >= begin_ns;
    };
    return !covers(first.timestamp_ns, last.timestamp_ns) && covers(first.right_ns, last.right_ns);
}

}  // namespace

StoredDive::StoredDive(const std::filesystem::path& path,
                       const std::filesystem::path& scratch,
                       const DiveLimits& limits,
                       const base::ProgressCallback& progress,
                       Links links)
    : limits_(limits),
      files_(open_source(path, scratch, limits, throttled(progress), findings_, links)),
      contents_(read_contents(files_, limits, findings_)),
      reader_(0, kPrefetchedPairs, {}) {
    report_other_dives();
    adapt_to_image_size(files_, contents_, findings_);
    pair_images();
    check_coverage(contents_, findings_);
    check_mesh(kReferenceMesh);
    check_mesh(kSceneMesh);
    if (!contents_.has_rig) return;
    check_gravity_direction(contents_, findings_);
    reader_ =
        FrameReader(num_frames(), kPrefetchedPairs, [this](int index) { return load(index); });
    check_first_images();
    if (has_error(findings_.all())) return;
    const auto load_pair = [this](int index, Eyes eyes = Eyes::Both) { return load(index, eyes); };
    contents_.fixed_pattern =
        check_images(num_frames(), load_pair, contents_.frames.delay.share_fitting, findings_);
    check_motion(contents_, load_pair, progress, findings_);
}

void StoredDive::report_other_dives() {
    for (const std::string& folder : files_.other_dives())
        findings_.warning("further_dive",
                          printable(folder),
                          "there is another dive in " + printable(folder) + ": it is not used",
                          "Pass one dive at a time: its folder, or an archive of its folder.");
}

// Pairs left and right images, by their timestamps alone if nothing is known of the cameras.
void StoredDive::pair_images() {
    const auto load_from = [this](const types::Camera& camera) {
        return [this, &camera](const CameraRow& row) {
            return load_image(files_, row.file, camera, limits_, Channels::Grey).image;
        };
    };
    const CameraImages images{contents_.left_rows,
                              contents_.right_rows,
                              load_from(contents_.rig.cam0),
                              load_from(contents_.rig.cam1)};
    if (contents_.has_rig) contents_.frames = pair_frames(images, contents_.rig);
    if (contents_.has_rig && follow_right_clock(contents_)) use_right_clock(contents_.frames);
    if (!contents_.has_rig)
        contents_.frames.pairs =
            match_pairs(images.left, images.right, {}, common_clock_tolerance_ns(images.left));
    const double sigma_m = contents_.frames.shared_delay_sigma_m();
    if (sigma_m > 0.0)
        contents_.rig.right_delay_baseline_sigma = sigma_m / contents_.rig.baseline_m();
    report_pairs(contents_.frames, images, contents_.rig.baseline_m(), findings_);
}

LoadedPair StoredDive::load(int index, Eyes eyes) const {
    const FramePair& files = contents_.frames.pairs[static_cast<std::size_t>(index)];
    LoadedPair pair;
    pair.index = index;
    pair.left = load_image(files_, files.left, contents_.rig.cam0, limits_, Channels::Grey);
    if (pair.left.image.empty() || eyes == Eyes::Left) return pair;
    pair.right = load_image(files_, files.right, contents_.rig.cam1, limits_, Channels::Grey);
    return pair;
}

void StoredDive::check_mesh(const char* file) {
    try {
        read_mesh(file);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        findings_.error("reference_unreadable",
                        file,
                        printable(error.what()),
                        "Write it as PLY with x, y, z and triangles, or remove it.");
    }
}

// Detects a calibration of another resolution early; a dive is not refused for a single odd image.
void StoredDive::check_first_images() {
    int num_other_size = 0;
    const int num_probed = std::min(kImagesProbed, num_frames());
    LoadedPair other;
    for (int i = 0; i < num_probed; ++i) {
        LoadedPair pair = load(i * num_frames() / num_probed);
        if (pair.is_complete()) return;
        if (pair.left.code != "image_size" && pair.right.code != "image_size") continue;
        if (num_other_size++ == 0) other = std::move(pair);
    }
    if (num_other_size == 0) return;
    const bool is_left = other.left.code == "image_size";
    const FramePair& files = contents_.frames.pairs[static_cast<std::size_t>(other.index)];
    findings_.error("image_size",
                    printable(is_left ? files.left : files.right),
                    "the images do not have the calibrated size: " +
                        (is_left ? other.left.problem : other.right.problem),
                    remedy_for("image_size"));
}

std::optional<types::StereoFrame> StoredDive::next_frame() {
    while (auto pair = next_pair()) {
        if ((pair->left.was_16_bit || pair->right.was_16_bit) && !has_reported_16_bit_) {
            has_reported_16_bit_ = true;
            const FramePair& files = contents_.frames.pairs[static_cast<std::size_t>(pair->index)];
            findings_.warning("image_16_bit",
                              printable(pair->left.was_16_bit ? files.left : files.right),
                              "images have 16 bits per channel; only the upper 8 are used",
                              "Record 8 bits, or scale 10- and 12-bit data to the full range.");
        }
        leave_out_repeated(*pair);
        if (pair->is_complete()) return frame_of(std::move(*pair));
        report_skipped(*pair);
    }
    return std::nullopt;
}

// Reads the first pairs ahead, so that it is known how much the scene moves before one of them is
// compared with the one before it.
std::optional<LoadedPair> StoredDive::next_pair() {
    if (!std::exchange(has_begun_, true)) {
        std::vector<cv::Mat> left;
        std::vector<cv::Mat> right;
        while (std::ssize(first_) < kNumFirstPairs) {
            auto pair = reader_.next();
            if (!pair) break;
            left.push_back(pair->left.image);
            right.push_back(pair->right.image);
            first_.push_back(std::move(*pair));
        }
        repeated_left_.learn(left);
        repeated_right_.learn(right);
    }
    if (first_.empty()) return reader_.next();
    LoadedPair pair = std::move(first_.front());
    first_.pop_front();
    return pair;
}

void StoredDive::leave_out_repeated(LoadedPair& pair) {
    const auto check = [](RepeatedImages& repeated, LoadedImage& now) {
        if (now.image.empty()) return;
        const auto kind = repeated.add(now.image);
        if (kind == RepeatedImages::Kind::No) return;
        now = {{},
               "image_repeated",
               kind == RepeatedImages::Kind::Exact
                   ? "it is the image of the frame before, bit by bit"
                   : "it is the image of the frame before, encoded again",
               false};
    };
    check(repeated_left_, pair.left);
    check(repeated_right_, pair.right);
}

std::optional<types::StereoFrame> StoredDive::frame(int index) const {
    LoadedPair pair = load(index);
    if (!pair.is_complete()) return std::nullopt;
    return frame_of(std::move(pair));
}

types::StereoFrame StoredDive::frame_of(LoadedPair pair) const {
    const FramePair& files = contents_.frames.pairs[static_cast<std::size_t>(pair.index)];
    types::StereoFrame frame;
    frame.index = pair.index;
    frame.timestamp_ns = files.timestamp_ns;
    frame.right_delay_s = contents_.frames.right_delay_s(files);
    frame.left = std::move(pair.left.image);
    frame.right = std::move(pair.right.image);
    return frame;
}

cv::Mat StoredDive::left_in_color(int frame_index, int reduction) const {
    const std::string& file = contents_.frames.pairs[static_cast<std::size_t>(frame_index)].left;
    LoadedImage loaded =
        load_image(files_, file, contents_.rig.cam0, limits_, Channels::Bgr, reduction);
    if (loaded.image.empty())
        throw Error(
            ErrorCode::Unavailable,
            printable(file) + " was decoded before and cannot be decoded now: " + loaded.problem);
    return loaded.image;
}

void StoredDive::report_skipped(const LoadedPair& pair) {
    if (!skipped_.insert(pair.index).second) return;
    const FramePair& files = contents_.frames.pairs[static_cast<std::size_t>(pair.index)];
    const bool is_left = pair.left.image.empty();
    const LoadedImage& loaded = is_left ? pair.left : pair.right;
    const std::string file = printable(is_left ? files.left : files.right);
    findings_.warning(
        loaded.code,
        file,
        "frame " + std::to_string(pair.index) + " is skipped, " + file + ": " + loaded.problem,
        remedy_for(loaded.code));
}

const ContentHash& StoredDive::content_hash() const {
    hash_contents(base::ignore_progress);
    return content_hash_;
}

void StoredDive::hash_contents(const base::ProgressCallback& progress) const {
    if (content_hash_.sha256.empty()) content_hash_ = files_.content_hash(throttled(progress));
}

double StoredDive::duration_s() const {
    if (contents_.frames.pairs.empty()) return 0.0;
    return base::to_s(contents_.frames.pairs.back().timestamp_ns -
                      contents_.frames.pairs.front().timestamp_ns);
}

std::optional<types::Mesh> StoredDive::read_mesh(const char* file) const {
    if (!files_.has(file)) return std::nullopt;
    const auto bytes = files_.read(file, limits_.max_file_bytes);
    if (!bytes)
        throw Error(ErrorCode::BadData,
                    std::string(file) + " is too large: simplify it or remove it");
    return io::parse_ply(*bytes, file);
}

std::optional<types::Mesh> StoredDive::read_reference_mesh() const {
    return read_mesh(kReferenceMesh);
}

std::optional<types::Mesh> StoredDive::read_scene_mesh() const { return read_mesh(kSceneMesh); }

std::unique_ptr<Dive> Dive::open(const std::filesystem::path& path,
                                 const std::filesystem::path& scratch,
                                 const DiveLimits& limits,
                                 const base::ProgressCallback& progress,
                                 Links links) {
    return std::make_unique<StoredDive>(path, scratch, limits, progress, links);
}

}  // namespace divemesh::dive
