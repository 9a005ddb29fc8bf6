#include "worker/simulator/camera_sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tbb/parallel_for.h>

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

constexpr int kToneSteps = 4096;

const std::array<std::uint8_t, kToneSteps + 1>& tone_curve() {
    static const auto kCurve = [] {
        std::array<std::uint8_t, kToneSteps + 1> table{};
        for (int i = 0; i <= kToneSteps; ++i)
            table[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(
                std::lround(255.0 * std::pow(i / static_cast<double>(kToneSteps), 1.0 / 2.2)));
        return table;
    }();
    return kCurve;
}

// Returns three approximately normal numbers (Irwin and Hall, sums of four) from the hashes of one
// pixel.
std::array<float, 3> normal3(std::uint64_t seed) {
    std::array<float, 3> draws{};
    for (std::uint64_t c = 0; c < 3; ++c) {
        const std::uint64_t hash = base::hash64(seed + c);
        const auto sum = static_cast<float>((hash & 0xffff) + ((hash >> 16) & 0xffff) +
                                            ((hash >> 32) & 0xffff) + (hash >> 48));
        draws[c] = (sum / 65536.0F - 2.0F) * 1.7320508F;
    }
    return draws;
}

}  // namespace

std::uint8_t tone(float linear) {
    const float clamped = std::clamp(linear, 0.0F, 1.0F);
    const float step = clamped * kToneSteps + 0.5F;
    return tone_curve()[static_cast<std::size_t>(step)];
}

cv::Mat develop(const cv::Mat& radiance,
                std::uint64_t image_number,
                double t_s,
                const SensorOptions& options) {
    cv::Mat image(radiance.size(), CV_8UC3);
    const auto wander =
        static_cast<float>(0.025 * std::sin(0.83 * t_s) + 0.015 * std::sin(2.1 * t_s + 1.0));
    const float gain = options.exposure * (1.0F + wander);
    const float center_u = 0.5F * static_cast<float>(radiance.cols - 1);
    const float center_v = 0.5F * static_cast<float>(radiance.rows - 1);
    const float corner2 = center_u * center_u + center_v * center_v;
    const std::uint64_t seed = base::hash64(options.seed, image_number);
    tbb::parallel_for(0, radiance.rows, [&](int v) {
        for (int u = 0; u < radiance.cols; ++u) {
            const float du = static_cast<float>(u) - center_u;
            const float dv = static_cast<float>(v) - center_v;
            const float light = gain * (1.0F - options.vignetting * (du * du + dv * dv) / corner2);
            const auto& linear = radiance.at<cv::Vec3f>(v, u);
            auto& stored = image.at<cv::Vec3b>(v, u);
            std::array<float, 3> draws{};
            if (options.noise)
                draws = normal3(base::hash64(seed + static_cast<std::uint64_t>(v) * 65536U +
                                             static_cast<std::uint64_t>(u)));
            for (int c = 0; c < 3; ++c) {
                const float electrons = std::max(0.0F, light * linear[c]) * options.full_well;
                const float deviation =
                    std::sqrt(electrons + options.read_noise * options.read_noise);
                stored[2 - c] = tone((electrons + draws[static_cast<std::size_t>(c)] * deviation) /
                                     options.full_well);
            }
        }
    });
    return image;
}

cv::Mat to_8_bit(const cv::Mat& linear) {
    cv::Mat image(linear.size(), CV_8UC3);
    for (int v = 0; v < linear.rows; ++v)
        for (int u = 0; u < linear.cols; ++u)
            for (int c = 0; c < 3; ++c)
                image.at<cv::Vec3b>(v, u)[2 - c] = tone(linear.at<cv::Vec3f>(v, u)[c]);
    return image;
}

}  // namespace divemesh::simulator
