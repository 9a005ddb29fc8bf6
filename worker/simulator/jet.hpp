#pragma once

#include <cmath>

namespace divemesh::simulator {

// A function of time with its first and second derivative by forward differentiation, exact to
// rounding.
struct Jet {
    double value = 0.0;
    double first = 0.0;
    double second = 0.0;
};

inline Jet constant(double value) { return {value, 0.0, 0.0}; }

inline Jet operator+(const Jet& a, const Jet& b) {
    return {a.value + b.value, a.first + b.first, a.second + b.second};
}
inline Jet operator*(const Jet& a, const Jet& b) {
    return {a.value * b.value,
            a.first * b.value + a.value * b.first,
            a.second * b.value + 2.0 * a.first * b.first + a.value * b.second};
}
inline Jet operator*(double s, const Jet& a) { return {s * a.value, s * a.first, s * a.second}; }
inline Jet operator+(const Jet& a, double s) { return {a.value + s, a.first, a.second}; }

inline Jet sin(const Jet& a) {
    const double s = std::sin(a.value);
    const double c = std::cos(a.value);
    return {s, c * a.first, c * a.second - s * a.first * a.first};
}
inline Jet cos(const Jet& a) {
    const double s = std::sin(a.value);
    const double c = std::cos(a.value);
    return {c, -s * a.first, -s * a.second - c * a.first * a.first};
}

}  // namespace divemesh::simulator
