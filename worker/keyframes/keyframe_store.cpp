#include "worker/keyframes/keyframe_store.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "worker/camera/range_correction.hpp"

namespace divemesh::keyframes {
namespace {

constexpr float kDisparityStep_px = 1.0F / 128.0F;
// Step in frames with disparities of 512 px and more, which half the size finds in wide images.
constexpr float kNearDisparityStep_px = 1.0F / 64.0F;
constexpr float kSigmaStep_px = 1.0F / 64.0F;
constexpr char kNearMagic[4] = {'D', 'M', 'K', '3'};
constexpr char kViewMagic[4] = {'D', 'M', 'V', '1'};

struct Header {
    char magic[4] = {'D', 'M', 'K', '2'};  // or kNearMagic: the step of the disparities
    std::int32_t width_px = 0;
    std::int32_t height_px = 0;

    bool is_near() const { return std::memcmp(magic, kNearMagic, sizeof magic) == 0; }
    float disparity_step_px() const {
        return is_near() ? kNearDisparityStep_px : kDisparityStep_px;
    }
};

// Returns whether a disparity is larger than the finer step can store.
bool has_near(const cv::Mat& disparity_px) {
    constexpr float kMax_px = kDisparityStep_px * std::numeric_limits<std::uint16_t>::max();
    const float* first = disparity_px.ptr<float>();
    return std::any_of(
        first, first + disparity_px.total(), [](float value) { return value > kMax_px; });
}

// Quantises values >= 0; values out of range become the max.
template <typename Stored>
void quantise(const cv::Mat& values, float step, std::vector<Stored>& stored) {
    const float* value = values.ptr<float>();
    const float per_step = 1.0F / step;
    constexpr auto kMaxStored = static_cast<float>(std::numeric_limits<Stored>::max());
    stored.resize(values.total());
    for (std::size_t i = 0; i < stored.size(); ++i) {
        const float scaled = std::min(std::max(0.0F, value[i]) * per_step + 0.5F, kMaxStored);
        stored[i] = static_cast<Stored>(static_cast<int>(scaled));
    }
}

// Returns the values from their stored form; `type` is CV_16U or CV_8U.
cv::Mat restored(const std::uint8_t* stored, const Header& header, int type, float step) {
    cv::Mat values;
    cv::Mat(header.height_px, header.width_px, type, const_cast<std::uint8_t*>(stored))
        .convertTo(values, CV_32F, step);
    return values;
}

std::vector<std::uint8_t> as_jpeg(const cv::Mat& image) {
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", image, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});
    return jpeg;
}

struct Bytes {
    const void* data;
    std::size_t num_bytes;
};

void write_file(const std::filesystem::path& path, std::initializer_list<Bytes> parts) {
    std::ofstream file(path, std::ios::binary);
    for (const Bytes& part : parts)
        file.write(static_cast<const char*>(part.data),
                   static_cast<std::streamsize>(part.num_bytes));
    file.close();
    if (!file)
        throw Error(ErrorCode::OutOfSpace,
                    "cannot write " + path.string() +
                        ": free space in the scratch folder or choose another folder");
}

// Returns the file's bytes; empty if there is no file.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) return {};
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(file.tellg()));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file) return {};
    return bytes;
}

// A keyframe file and the offsets of its parts.
struct KeyframeFile {
    std::vector<std::uint8_t> bytes;
    Header header;

    std::size_t num_pixels() const {
        return static_cast<std::size_t>(header.width_px) *
               static_cast<std::size_t>(header.height_px);
    }
    const std::uint8_t* disparities() const { return bytes.data() + sizeof header; }
    const std::uint8_t* sigmas() const { return disparities() + 2 * num_pixels(); }
};

[[noreturn]] void refuse_missing(const std::filesystem::path& path) {
    throw Error(ErrorCode::NotFound, "there is no keyframe file " + path.string());
}

[[noreturn]] void refuse_incomplete(const std::filesystem::path& path) {
    throw Error(ErrorCode::BadData, "keyframe file is incomplete: " + path.string());
}

bool is_valid(const Header& header) {
    return (header.is_near() ||
            std::memcmp(header.magic, Header{}.magic, sizeof header.magic) == 0) &&
           header.width_px >= 0 && header.height_px >= 0;
}

KeyframeFile read_keyframe(const std::filesystem::path& path) {
    KeyframeFile file{read_file(path), {}};
    if (file.bytes.size() < sizeof file.header) refuse_missing(path);
    std::memcpy(&file.header, file.bytes.data(), sizeof file.header);
    if (!is_valid(file.header) || file.bytes.size() != sizeof file.header + 3 * file.num_pixels())
        refuse_incomplete(path);
    return file;
}

}  // namespace

KeyframeStore::KeyframeStore(std::filesystem::path folder, LeftInColor left_in_color)
    : folder_(std::move(folder)), left_in_color_(std::move(left_in_color)) {
    std::filesystem::create_directories(folder_);
}

void KeyframeStore::clear() const {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
}

KeyframeStore KeyframeStore::at_own_range(std::shared_ptr<const types::RangeTable> ranges) const {
    KeyframeStore store = *this;
    store.ranges_ = std::move(ranges);
    return store;
}

KeyframeStore KeyframeStore::rerectified(
    std::shared_ptr<const camera::KeyframeRerectifier> rerectifier) const {
    KeyframeStore store = *this;
    store.rerectifier_ = std::move(rerectifier);
    return store;
}

KeyframeStore KeyframeStore::corrected(
    std::shared_ptr<const camera::ShutterCorrection> correction) const {
    KeyframeStore store = *this;
    store.correction_ = std::move(correction);
    return store;
}

std::filesystem::path KeyframeStore::file_of(int frame_index, const char* extension) const {
    char name[32];
    std::snprintf(name, sizeof name, "%08d.%s", frame_index, extension);
    return folder_ / name;
}

void KeyframeStore::write(int frame_index, const types::DepthMap& depth) const {
    const cv::Mat& disparity = depth.disparity_px;
    std::vector<std::uint16_t> disparities;
    std::vector<std::uint8_t> sigmas;
    Header header;
    if (has_near(disparity)) std::copy_n(kNearMagic, sizeof kNearMagic, header.magic);
    quantise(disparity, header.disparity_step_px(), disparities);
    quantise(depth.sigma_disparity_px, kSigmaStep_px, sigmas);

    header.width_px = disparity.cols;
    header.height_px = disparity.rows;
    write_file(file_of(frame_index, "keyframe"),
               {{&header, sizeof header},
                {disparities.data(), disparities.size() * sizeof(std::uint16_t)},
                {sigmas.data(), sigmas.size()}});
}

void KeyframeStore::write_left(int frame_index, const cv::Mat& left) const {
    const std::vector<std::uint8_t> jpeg = as_jpeg(left);
    write_file(file_of(frame_index, "jpg"), {{jpeg.data(), jpeg.size()}});
}

cv::Mat KeyframeStore::read_left(int frame_index) const {
    const std::vector<std::uint8_t> bytes = read_file(file_of(frame_index, "jpg"));
    cv::Mat left;
    if (!bytes.empty()) left = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    if (left.empty())
        throw Error(ErrorCode::BadData,
                    "keyframe image is damaged: " + file_of(frame_index, "jpg").string());
    return left;
}

void KeyframeStore::write_keypoints(int frame_index,
                                    const features::DescribedKeypoints& view) const {
    write_file(file_of(frame_index, "view"),
               {{kViewMagic, sizeof kViewMagic}, {view.data(), view.size() * sizeof view[0]}});
}

features::DescribedKeypoints KeyframeStore::read_keypoints(int frame_index) const {
    const std::vector<std::uint8_t> bytes = read_file(file_of(frame_index, "view"));
    const std::size_t num_bytes = bytes.size() - std::min(bytes.size(), sizeof kViewMagic);
    if (bytes.size() < sizeof kViewMagic ||
        std::memcmp(bytes.data(), kViewMagic, sizeof kViewMagic) != 0 ||
        num_bytes % sizeof(features::DescribedKeypoint) != 0)
        throw Error(ErrorCode::BadData,
                    "keyframe description is damaged: " + file_of(frame_index, "view").string());
    features::DescribedKeypoints view(num_bytes / sizeof(features::DescribedKeypoint));
    std::copy(bytes.begin() + sizeof kViewMagic,
              bytes.end(),
              reinterpret_cast<std::uint8_t*>(view.data()));
    return view;
}

types::KeyframeImages KeyframeStore::read(int frame_index) const {
    const KeyframeFile file = read_keyframe(file_of(frame_index, "keyframe"));
    types::KeyframeImages images;
    images.depth.disparity_px =
        restored(file.disparities(), file.header, CV_16U, file.header.disparity_step_px());
    images.depth.sigma_disparity_px = restored(file.sigmas(), file.header, CV_8U, kSigmaStep_px);
    if (left_in_color_) images.left_color = left_in_color_(frame_index);
    if (ranges_) images = camera::at_own_range(*ranges_, images);
    if (rerectifier_) images = rerectifier_->moved(images);
    return correction_ ? correction_->moved(frame_index, images) : images;
}

types::DepthMap KeyframeStore::read_depth(int frame_index) const {
    KeyframeStore store = *this;
    store.left_in_color_ = {};
    return store.read(frame_index).depth;
}

cv::Mat KeyframeStore::read_disparities(int frame_index, int step_px) const {
    const std::filesystem::path path = file_of(frame_index, "keyframe");
    std::ifstream file(path, std::ios::binary);
    Header header;
    if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) refuse_missing(path);
    if (!is_valid(header)) refuse_incomplete(path);
    const auto row_bytes = static_cast<std::streamoff>(sizeof(std::uint16_t)) * header.width_px;
    if (std::filesystem::file_size(path) !=
        sizeof header + 3 * static_cast<std::uintmax_t>(header.width_px) * header.height_px)
        refuse_incomplete(path);
    const float quantum_px = header.disparity_step_px();
    std::vector<std::uint16_t> row(static_cast<std::size_t>(header.width_px));
    cv::Mat disparities((header.height_px + step_px - 1) / step_px,
                        (header.width_px + step_px - 1) / step_px,
                        CV_32F);
    for (int y = 0; y < disparities.rows; ++y) {
        file.seekg(static_cast<std::streamoff>(sizeof header) + row_bytes * step_px * y);
        if (!file.read(reinterpret_cast<char*>(row.data()), row_bytes)) refuse_incomplete(path);
        for (int x = 0; x < disparities.cols; ++x)
            disparities.at<float>(y, x) =
                quantum_px * static_cast<float>(row[static_cast<std::size_t>(x) * step_px]);
    }
    return disparities;
}

cv::Mat KeyframeStore::left_in_color(int frame_index) const {
    if (!left_in_color_) return {};
    if (correction_ || ranges_) return read(frame_index).left_color;
    const cv::Mat color = left_in_color_(frame_index);
    return rerectifier_ ? rerectifier_->moved(color) : color;
}

}  // namespace divemesh::keyframes
