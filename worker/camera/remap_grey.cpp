#include "worker/camera/remap_grey.hpp"

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::camera {
namespace {

constexpr int kBits = cv::INTER_BITS;     // of the part of a pixel along one axis
constexpr int kOne = cv::INTER_TAB_SIZE;  // such parts in a pixel

// The four recorded pixels around each pixel of a row: two neighbours in one number, the left one
// in its low byte.
struct Neighbours {
    std::vector<std::uint16_t> upper;
    std::vector<std::uint16_t> lower;
};

std::uint16_t two(int left, int right) { return static_cast<std::uint16_t>(left | right << 8); }

std::uint16_t two_at(const std::uint8_t* from) { return two(from[0], from[1]); }

std::uint16_t two_at_border(const cv::Mat& image, int x, int y) {
    const auto at = [&](int column) {
        const bool is_inside = y >= 0 && y < image.rows && column >= 0 && column < image.cols;
        return is_inside ? int{image.ptr<std::uint8_t>(y)[column]} : 0;
    };
    return two(at(x), at(x + 1));
}

void read_neighbours(const cv::Mat& image, const std::int16_t* pixels, Neighbours& row) {
    const std::uint8_t* const data = image.data;
    const auto step = static_cast<std::ptrdiff_t>(image.step);
    const auto last_x = static_cast<unsigned>(image.cols - 1);
    const auto last_y = static_cast<unsigned>(image.rows - 1);
    for (std::size_t i = 0; i < row.upper.size(); ++i) {
        const int x = pixels[2 * i];
        const int y = pixels[2 * i + 1];
        if (static_cast<unsigned>(x) < last_x && static_cast<unsigned>(y) < last_y) {
            const std::uint8_t* const from = data + y * step + x;
            row.upper[i] = two_at(from);
            row.lower[i] = two_at(from + step);
        } else {
            row.upper[i] = two_at_border(image, x, y);
            row.lower[i] = two_at_border(image, x, y + 1);
        }
    }
}

DIVEMESH_INLINE_BODY int between(int pair, int part) {
    return (pair & 0xff) * (kOne - part) + (pair >> 8) * part;
}

DIVEMESH_INLINE_BODY void interpolate_row(const std::uint16_t* __restrict upper,
                                          const std::uint16_t* __restrict lower,
                                          const std::uint16_t* __restrict parts,
                                          int num,
                                          std::uint8_t* __restrict out) {
    constexpr int kHalf = kOne * kOne / 2;
    for (int i = 0; i < num; ++i) {
        const int part_x = parts[i] & (kOne - 1);
        const int part_y = parts[i] >> kBits;
        const int sum =
            between(upper[i], part_x) * (kOne - part_y) + between(lower[i], part_x) * part_y;
        out[i] = static_cast<std::uint8_t>((sum + kHalf) >> (2 * kBits));
    }
}

}  // namespace

cv::Mat remap_grey(const cv::Mat& image, const cv::Mat& pixels, const cv::Mat& parts) {
    static const auto kInterpolate = base::compiled_for<interpolate_row>(base::best_instructions());
    cv::Mat result(pixels.size(), CV_8UC1);
    Neighbours row;
    row.upper.resize(static_cast<std::size_t>(pixels.cols));
    row.lower.resize(static_cast<std::size_t>(pixels.cols));
    for (int y = 0; y < pixels.rows; ++y) {
        read_neighbours(image, pixels.ptr<std::int16_t>(y), row);
        kInterpolate(row.upper.data(),
                     row.lower.data(),
                     parts.ptr<std::uint16_t>(y),
                     pixels.cols,
                     result.ptr<std::uint8_t>(y));
    }
    return result;
}

}  // namespace divemesh::camera
