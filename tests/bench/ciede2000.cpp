#include "tests/bench/ciede2000.hpp"

#include <cmath>
#include <numbers>

namespace divemesh::bench {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

double f_of(double t) {
    constexpr double kDelta = 6.0 / 29.0;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
}

double hue_deg(double a, double b) {
    if (a == 0.0 && b == 0.0) return 0.0;
    const double hue = kDegPerRad * std::atan2(b, a);
    return hue < 0.0 ? hue + 360.0 : hue;
}

double cos_deg(double angle) { return std::cos(angle / kDegPerRad); }

// Chroma C' and hue h' of a colour.
struct Chroma {
    double chroma = 0.0;
    double hue = 0.0;
};

Chroma chroma_of(const Lab& color, double weight) {
    const double a = (1.0 + weight) * color.a;
    return {std::hypot(a, color.b), hue_deg(a, color.b)};
}

double hue_difference(const Chroma& one, const Chroma& other) {
    if (one.chroma * other.chroma == 0.0) return 0.0;
    const double difference = other.hue - one.hue;
    if (difference > 180.0) return difference - 360.0;
    if (difference < -180.0) return difference + 360.0;
    return difference;
}

double mean_hue(const Chroma& one, const Chroma& other) {
    const double sum = one.hue + other.hue;
    if (one.chroma * other.chroma == 0.0) return sum;
    if (std::abs(one.hue - other.hue) <= 180.0) return 0.5 * sum;
    return sum < 360.0 ? 0.5 * (sum + 360.0) : 0.5 * (sum - 360.0);
}

// Returns the root of c^7 / (c^7 + 25^7).
double saturation(double chroma) {
    const double power = std::pow(chroma, 7.0);
    return std::sqrt(power / (power + std::pow(25.0, 7.0)));
}

}  // namespace

Lab lab_of(const std::array<double, 3>& rgb) {
    const double x = (0.4124564 * rgb[0] + 0.3575761 * rgb[1] + 0.1804375 * rgb[2]) / 0.95047;
    const double y = 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2];
    const double z = (0.0193339 * rgb[0] + 0.1191920 * rgb[1] + 0.9503041 * rgb[2]) / 1.08883;
    return {116.0 * f_of(y) - 16.0, 500.0 * (f_of(x) - f_of(y)), 200.0 * (f_of(y) - f_of(z))};
}

double ciede2000(const Lab& one, const Lab& other) {
    const double mean_plain_chroma =
        0.5 * (std::hypot(one.a, one.b) + std::hypot(other.a, other.b));
    const double weight = 0.5 * (1.0 - saturation(mean_plain_chroma));
    const Chroma c1 = chroma_of(one, weight);
    const Chroma c2 = chroma_of(other, weight);
    const double mean_chroma = 0.5 * (c1.chroma + c2.chroma);
    const double hue = mean_hue(c1, c2);
    const double hue_step = 2.0 * std::sqrt(c1.chroma * c2.chroma) *
                            std::sin(0.5 * hue_difference(c1, c2) / kDegPerRad);
    const double t = 1.0 - 0.17 * cos_deg(hue - 30.0) + 0.24 * cos_deg(2.0 * hue) +
                     0.32 * cos_deg(3.0 * hue + 6.0) - 0.20 * cos_deg(4.0 * hue - 63.0);
    const double from_middle = std::pow(0.5 * (one.l + other.l) - 50.0, 2.0);
    const double lightness =
        (other.l - one.l) / (1.0 + 0.015 * from_middle / std::sqrt(20.0 + from_middle));
    const double chroma = (c2.chroma - c1.chroma) / (1.0 + 0.045 * mean_chroma);
    const double turned = hue_step / (1.0 + 0.015 * mean_chroma * t);
    const double blue_deg = 60.0 * std::exp(-std::pow((hue - 275.0) / 25.0, 2.0));
    const double rotation = -2.0 * saturation(mean_chroma) * std::sin(blue_deg / kDegPerRad);
    return std::sqrt(lightness * lightness + chroma * chroma + turned * turned +
                     rotation * chroma * turned);
}

}  // namespace divemesh::bench
