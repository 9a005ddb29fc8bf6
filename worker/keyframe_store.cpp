#include "worker/keyframe_store.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::worker {
namespace {

constexpr float kDisparityStep_px = 1.0F / 128.0F;
constexpr float kSigmaStep_px = 1.0F / 64.0F;

struct Header {
    char magic[4] = {'D', 'M', 'K', '1'};
    std::int32_t width_px = 0;
    std::int32_t height_px = 0;
    std::int32_t jpeg_bytes = 0;
};

template <typename Stored>
Stored quantise(float value, float step) {
    const float scaled = std::round(value / step);
    const auto largest = static_cast<float>(std::numeric_limits<Stored>::max());
    return static_cast<Stored>(std::clamp(scaled, 0.0F, largest));
}

std::vector<std::uint8_t> as_jpeg(const cv::Mat& picture) {
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});
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
                        ": free space in the scratch folder or choose another one");
}

// Empty when there is none.
std::vector<char> read_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

KeyframeStore::KeyframeStore(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_);
}

KeyframeStore KeyframeStore::rerectified(
    std::shared_ptr<const KeyframeRerectifier> rerectifier) const {
    KeyframeStore store = *this;
    store.rerectifier_ = std::move(rerectifier);
    return store;
}

std::filesystem::path KeyframeStore::file_of(int frame_index, const char* extension) const {
    char name[32];
    std::snprintf(name, sizeof name, "%08d.%s", frame_index, extension);
    return folder_ / name;
}

void KeyframeStore::write(int frame_index, const KeyframeImages& images) const {
    const cv::Mat& disparity = images.depth.disparity_px;
    const auto num_pixels = disparity.total();
    std::vector<std::uint16_t> disparities(num_pixels);
    std::vector<std::uint8_t> sigmas(num_pixels);
    for (std::size_t i = 0; i < num_pixels; ++i) {
        disparities[i] = quantise<std::uint16_t>(disparity.ptr<float>()[i], kDisparityStep_px);
        sigmas[i] =
            quantise<std::uint8_t>(images.depth.sigma_disparity_px.ptr<float>()[i], kSigmaStep_px);
    }
    const std::vector<std::uint8_t> jpeg = as_jpeg(images.left_color);

    Header header;
    header.width_px = disparity.cols;
    header.height_px = disparity.rows;
    header.jpeg_bytes = static_cast<std::int32_t>(jpeg.size());
    write_file(file_of(frame_index, "keyframe"),
               {{&header, sizeof header},
                {disparities.data(), num_pixels * sizeof(std::uint16_t)},
                {sigmas.data(), num_pixels},
                {jpeg.data(), jpeg.size()}});
}

void KeyframeStore::write_left(int frame_index, const cv::Mat& left) const {
    const std::vector<std::uint8_t> jpeg = as_jpeg(left);
    write_file(file_of(frame_index, "jpg"), {{jpeg.data(), jpeg.size()}});
}

cv::Mat KeyframeStore::read_left(int frame_index) const {
    const std::vector<char> bytes = read_file(file_of(frame_index, "jpg"));
    cv::Mat left;
    if (!bytes.empty()) left = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    if (left.empty())
        throw Error(ErrorCode::BadData,
                    "keyframe picture damaged: " + file_of(frame_index, "jpg").string());
    return left;
}

KeyframeImages KeyframeStore::read(int frame_index) const {
    const auto path = file_of(frame_index, "keyframe");
    const std::vector<char> bytes = read_file(path);
    Header header;
    if (bytes.size() < sizeof header)
        throw Error(ErrorCode::NotFound, "no keyframe file " + path.string());
    std::memcpy(&header, bytes.data(), sizeof header);
    const auto num_pixels =
        static_cast<std::size_t>(header.width_px) * static_cast<std::size_t>(header.height_px);
    const auto jpeg_bytes = static_cast<std::size_t>(header.jpeg_bytes);
    if (std::memcmp(header.magic, Header{}.magic, sizeof header.magic) != 0 ||
        bytes.size() != sizeof header + 3 * num_pixels + jpeg_bytes)
        throw Error(ErrorCode::BadData, "keyframe file cut short: " + path.string());

    KeyframeImages images;
    images.depth.disparity_px.create(header.height_px, header.width_px, CV_32F);
    images.depth.sigma_disparity_px.create(header.height_px, header.width_px, CV_32F);
    const char* disparities = bytes.data() + sizeof header;
    const char* sigmas = disparities + num_pixels * sizeof(std::uint16_t);
    for (std::size_t i = 0; i < num_pixels; ++i) {
        std::uint16_t disparity = 0;
        std::memcpy(&disparity, disparities + i * sizeof disparity, sizeof disparity);
        images.depth.disparity_px.ptr<float>()[i] =
            static_cast<float>(disparity) * kDisparityStep_px;
        images.depth.sigma_disparity_px.ptr<float>()[i] =
            static_cast<float>(static_cast<std::uint8_t>(sigmas[i])) * kSigmaStep_px;
    }
    const auto* jpeg = reinterpret_cast<const std::uint8_t*>(sigmas + num_pixels);
    images.left_color =
        cv::imdecode(std::vector<std::uint8_t>(jpeg, jpeg + jpeg_bytes), cv::IMREAD_COLOR);
    return rerectifier_ ? rerectifier_->moved(images) : images;
}

}  // namespace divemesh::worker
