#include "worker/keyframe_store.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
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

std::filesystem::path KeyframeStore::file_of(int frame_index) const {
    char name[32];
    std::snprintf(name, sizeof name, "%08d.keyframe", frame_index);
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
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", images.left_color, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});

    Header header;
    header.width_px = disparity.cols;
    header.height_px = disparity.rows;
    header.jpeg_bytes = static_cast<std::int32_t>(jpeg.size());
    std::ofstream file(file_of(frame_index), std::ios::binary);
    const auto put = [&](const void* data, std::size_t num_bytes) {
        file.write(static_cast<const char*>(data), static_cast<std::streamsize>(num_bytes));
    };
    put(&header, sizeof header);
    put(disparities.data(), num_pixels * sizeof(std::uint16_t));
    put(sigmas.data(), num_pixels);
    put(jpeg.data(), jpeg.size());
    file.close();
    if (!file)
        throw Error(ErrorCode::OutOfSpace,
                    "cannot write " + file_of(frame_index).string() +
                        ": free space in the scratch folder or choose another one");
}

KeyframeImages KeyframeStore::read(int frame_index) const {
    std::ifstream file(file_of(frame_index), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    Header header;
    if (bytes.size() < sizeof header)
        throw Error(ErrorCode::NotFound, "no keyframe file " + file_of(frame_index).string());
    std::memcpy(&header, bytes.data(), sizeof header);
    const auto num_pixels =
        static_cast<std::size_t>(header.width_px) * static_cast<std::size_t>(header.height_px);
    const auto jpeg_bytes = static_cast<std::size_t>(header.jpeg_bytes);
    if (std::memcmp(header.magic, Header{}.magic, sizeof header.magic) != 0 ||
        bytes.size() != sizeof header + 3 * num_pixels + jpeg_bytes)
        throw Error(ErrorCode::BadData,
                    "keyframe file cut short: " + file_of(frame_index).string());

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
