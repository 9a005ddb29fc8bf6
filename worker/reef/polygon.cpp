#include "worker/reef/polygon.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::reef {
namespace {

constexpr double kOnBorder_m = 1e-9;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
}

double signed_area(const Polygon& polygon) {
    double twice = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        twice += cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
    return 0.5 * twice;
}

double distance_to_side(const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b,
                        const Eigen::Vector2d& point) {
    const Eigen::Vector2d way = b - a;
    const double share = std::clamp((point - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
    return (point - a - share * way).norm();
}

bool sides_meet(const Eigen::Vector2d& a,
                const Eigen::Vector2d& b,
                const Eigen::Vector2d& c,
                const Eigen::Vector2d& d) {
    const double c_side = cross(b - a, c - a);
    const double d_side = cross(b - a, d - a);
    const double a_side = cross(d - c, a - c);
    const double b_side = cross(d - c, b - c);
    if (c_side * d_side < 0.0 && a_side * b_side < 0.0) return true;
    return distance_to_side(a, b, c) < kOnBorder_m || distance_to_side(a, b, d) < kOnBorder_m ||
           distance_to_side(c, d, a) < kOnBorder_m || distance_to_side(c, d, b) < kOnBorder_m;
}

// Returns the part to the left of the line from a to b.
Polygon clipped(const Polygon& polygon, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    Polygon left;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Eigen::Vector2d& here = polygon[i];
        const Eigen::Vector2d& next = polygon[(i + 1) % polygon.size()];
        const double side_here = cross(b - a, here - a);
        const double side_next = cross(b - a, next - a);
        if (side_here >= 0.0) left.push_back(here);
        if ((side_here < 0.0) != (side_next < 0.0))
            left.push_back(here + side_here / (side_here - side_next) * (next - here));
    }
    return left;
}

}  // namespace

double area_m2(const Polygon& polygon) {
    return polygon.empty() ? 0.0 : std::abs(signed_area(polygon));
}

bool is_self_crossing(const Polygon& polygon) {
    const std::size_t num = polygon.size();
    for (std::size_t i = 0; i < num; ++i)
        if ((polygon[(i + 1) % num] - polygon[i]).norm() < kOnBorder_m) return true;
    for (std::size_t i = 0; i < num; ++i)
        for (std::size_t k = i + 2; k < num; ++k) {
            if ((k + 1) % num == i) continue;
            if (sides_meet(polygon[i], polygon[i + 1], polygon[k], polygon[(k + 1) % num]))
                return true;
        }
    return false;
}

bool contains(const Polygon& polygon, const Eigen::Vector2d& point) {
    bool is_inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Eigen::Vector2d& a = polygon[i];
        const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
        if (distance_to_side(a, b, point) <= kOnBorder_m) return true;
        if ((a.y() > point.y()) == (b.y() > point.y())) continue;
        const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        if (point.x() < x) is_inside = !is_inside;
    }
    return is_inside;
}

double max_diameter_m(const Polygon& polygon) {
    double longest = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            longest = std::max(longest, (polygon[i] - polygon[k]).squaredNorm());
    return std::sqrt(longest);
}

double overlap_m2(const Polygon& polygon,
                  const Eigen::Vector2d& a,
                  const Eigen::Vector2d& b,
                  const Eigen::Vector2d& c) {
    const bool is_left = cross(b - a, c - a) > 0.0;
    const Eigen::Vector2d& second = is_left ? b : c;
    const Eigen::Vector2d& third = is_left ? c : b;
    return area_m2(clipped(clipped(clipped(polygon, a, second), second, third), third, a));
}

}  // namespace divemesh::reef
