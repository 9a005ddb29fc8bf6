#include "worker/color/linear_light.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core/fast_math.hpp>
#include <vector>

namespace divemesh::color {
namespace {

constexpr double kGamma = 2.2;
constexpr std::size_t kSteps = std::size_t{1} << 16;  // as fine as the second darkest level

std::array<float, 256> make_levels() {
    std::array<float, 256> levels{};
    for (std::size_t i = 0; i < levels.size(); ++i)
        levels[i] = static_cast<float>(std::pow(static_cast<double>(i) / 255.0, kGamma));
    return levels;
}

std::vector<std::uint8_t> make_codes() {
    std::vector<std::uint8_t> codes(kSteps + 1);
    for (std::size_t i = 0; i <= kSteps; ++i)
        codes[i] = static_cast<std::uint8_t>(std::lround(
            255.0 * std::pow(static_cast<double>(i) / static_cast<double>(kSteps), 1.0 / kGamma)));
    return codes;
}

}  // namespace

const std::array<float, 256>& linear_levels() {
    static const std::array<float, 256> kLevels = make_levels();
    return kLevels;
}

std::uint8_t level_of(float linear) {
    static const std::vector<std::uint8_t> kCodes = make_codes();
    const float clamped = linear > 0.0F ? std::min(linear, 1.0F) : 0.0F;  // NaN too
    return kCodes[static_cast<std::size_t>(cvRound(clamped * static_cast<float>(kSteps)))];
}

}  // namespace divemesh::color
