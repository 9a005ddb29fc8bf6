#include "worker/color/restorer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace divemesh::color {
namespace {

constexpr std::size_t kNumSteps = 512;  // of the range: linear between is within 0.1 %
// The least response of a corner, by vignetting: chosen, for fits that go astray.
constexpr float kMinResponse = 0.2F;

}  // namespace

Restorer::Restorer(const ColorFit& fit, const WhitePoint& white)
    : near_m_(static_cast<float>(fit.near_m)),
      far_m_(static_cast<float>(fit.far_m)),
      steps_per_m_(static_cast<float>(static_cast<double>(kNumSteps) /
                                      std::max(1e-3, fit.far_m - fit.near_m))),
      vignetting_(static_cast<float>(fit.vignetting)) {
    if (!fit.is_known()) throw std::logic_error("colours are restored by a fit that failed");
    for (const double log_gain : fit.log_gains)
        inverse_gains_.push_back(static_cast<float>(std::exp(-log_gain)));
    for (std::size_t c = 0; c < 3; ++c)
        largest_[c] = static_cast<float>(kMaxNoise / std::max(1e-6, fit.channels[c].noise));
    for (std::size_t i = 0; i <= kNumSteps; ++i) {
        const double range_m =
            fit.near_m + (fit.far_m - fit.near_m) * static_cast<double>(i) / kNumSteps;
        Step& step = steps_.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
            const DirectShare direct = direct_share(fit.channels[c], fit.light, range_m);
            step.added[c] = static_cast<float>(backscatter(fit.channels[c], range_m));
            step.sky[c] = static_cast<float>(direct.sky * white.white[c]);
            step.lamps[c] = static_cast<float>(direct.lamps * white.white[c]);
        }
    }
}

Restorer::Step Restorer::step_at(float range_m) const {
    const float place = std::clamp(
        (range_m - near_m_) * steps_per_m_, 0.0F, static_cast<float>(kNumSteps) - 0.001F);
    const auto below = static_cast<std::size_t>(place);
    const float share = place - static_cast<float>(below);
    const Step& a = steps_[below];
    const Step& b = steps_[below + 1];
    Step step{};
    for (std::size_t c = 0; c < 3; ++c) {
        step.added[c] = a.added[c] + share * (b.added[c] - a.added[c]);
        step.sky[c] = a.sky[c] + share * (b.sky[c] - a.sky[c]);
        step.lamps[c] = a.lamps[c] + share * (b.lamps[c] - a.lamps[c]);
    }
    return step;
}

RestoredColor Restorer::restore(const Seen& seen, std::size_t keyframe) const {
    const Step step = step_at(seen.range_m);
    const float response = std::max(kMinResponse, 1.0F - vignetting_ * seen.eccentricity);
    const float inverse_response = inverse_gains_[keyframe] / response;
    RestoredColor restored;
    restored.is_limited = seen.range_m > far_m_;
    for (std::size_t c = 0; c < 3; ++c) {
        const float whole = inverse_response / (step.sky[c] + step.lamps[c] * seen.cosine);
        const float factor = std::min(whole, largest_[c]);
        restored.rgb[c] = std::max(0.0F, seen.rgb[c] - step.added[c] / inverse_response) * factor;
        restored.amplification += factor / 3.0F;
        restored.is_limited = restored.is_limited || whole > largest_[c];
    }
    return restored;
}

}  // namespace divemesh::color
