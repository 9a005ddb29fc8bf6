#include "worker/color/fit_priors.hpp"

namespace divemesh::color {
namespace {

// Standard deviations, and means that are not 0: chosen so wide that they decide only what the
// sightings leave open.
constexpr double kGain = 0.5;      // of the logarithm
constexpr double kGainStep = 0.5;  // from one knot to the next
constexpr double kVignettingMean = 0.15;
constexpr double kVignetting = 0.2;
constexpr double kAttenuationMean_per_m = 0.3;
constexpr double kAttenuation_per_m = 3.0;
constexpr double kVeil = 1.0;  // water as bright as white
constexpr double kLamp = 3.0;
// The coefficients of backscatter and attenuation are of the same water (Akkaynak et al., "What is
// the space of attenuation coefficients in underwater computer vision?", 2017). By how much they
// may differ is chosen: about half of a common coefficient of green light.
constexpr double kBackscatterLessAttenuation_per_m = 0.15;

}  // namespace

// Calls visit(column, other, ahead, sigma) for each prior: of an unknown, or of its difference to
// that in the column `other` (not kNone). Its mean lies `ahead` of its present value.
template <typename Visit>
void FitPriors::for_each(const Visit& visit) const {
    constexpr int kNone = FitColumns::kNone;
    const std::vector<double>& log_gains = unknowns_.log_gains;
    for (std::size_t i = 0; i < log_gains.size(); ++i) {
        const int column = columns_.gains + static_cast<int>(i);
        visit(column, kNone, -log_gains[i], kGain);
        if (i > 0) visit(column, column - 1, log_gains[i - 1] - log_gains[i], kGainStep);
    }
    visit(columns_.shared[0].back(), kNone, kVignettingMean - unknowns_.vignetting, kVignetting);
    for (std::size_t c = 0; c < unknowns_.channels.size(); ++c) {
        const ChannelUnknowns& channel = unknowns_.channels[c];
        const auto& of = columns_.shared[c];
        if (of[3] != kNone) visit(of[3], kNone, -channel.lamp, kLamp);
        if (!model_.has_water) continue;
        visit(of[0], kNone, kAttenuationMean_per_m - channel.attenuation_per_m, kAttenuation_per_m);
        visit(of[1],
              of[0],
              channel.attenuation_per_m - channel.backscatter_per_m,
              kBackscatterLessAttenuation_per_m);
        visit(of[2], kNone, -channel.veil, kVeil);
    }
}

double FitPriors::loss() const {
    double sum = 0.0;
    for_each([&](int, int, double ahead, double sigma) { sum += ahead * ahead / (sigma * sigma); });
    return sum;
}

void FitPriors::add_to(NormalEquations& equations) const {
    for_each([&](int column, int other, double ahead, double sigma) {
        const double weight = 1.0 / (sigma * sigma);
        equations.H(column, column) += weight;
        equations.b[column] += weight * ahead;
        if (other == FitColumns::kNone) return;
        equations.H(other, other) += weight;
        equations.H(column, other) -= weight;
        equations.H(other, column) -= weight;
        equations.b[other] -= weight * ahead;
    });
}

}  // namespace divemesh::color
