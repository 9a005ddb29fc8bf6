#include "worker/simulator/shapes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

int num_steps(float length_m, float step_m) {
    return std::max(1, static_cast<int>(std::lround(length_m / step_m)));
}

// Adds a grid of (columns + 1) x (rows + 1) points; its outside is in the direction of u x v.
template <typename Point>
void add_grid(Shape& shape, int columns, int rows, const Point& point) {
    const auto first = static_cast<std::uint32_t>(shape.vertices.size());
    const auto width = static_cast<std::uint32_t>(columns + 1);
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i)
            shape.vertices.push_back(point(static_cast<float>(i) / static_cast<float>(columns),
                                           static_cast<float>(j) / static_cast<float>(rows)));
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j)
        for (std::uint32_t i = 0; i + 1 < width; ++i) {
            const std::uint32_t a = first + j * width + i;
            shape.triangles.push_back({a, a + 1, a + width + 1});
            shape.triangles.push_back({a, a + width + 1, a + width});
        }
}

// The six faces of a cube with half edge 1: normal, u, v with u x v = normal.
struct Face {
    int normal;
    int u;
    int v;
    float sign;
};
constexpr std::array<Face, 6> kFaces = {{{0, 1, 2, 1.0F},
                                         {0, 2, 1, -1.0F},
                                         {1, 2, 0, 1.0F},
                                         {1, 0, 2, -1.0F},
                                         {2, 0, 1, 1.0F},
                                         {2, 1, 0, -1.0F}}};

Eigen::Vector3f on_cube(const Face& face, float u, float v) {
    Eigen::Vector3f p;
    p[face.normal] = face.sign;
    p[face.u] = 2.0F * u - 1.0F;
    p[face.v] = 2.0F * v - 1.0F;
    return p;
}

// Adds a tapering round stick from a to b with a rounded end.
void add_stick(Shape& shape,
               const Eigen::Vector3f& a,
               const Eigen::Vector3f& b,
               const std::array<float, 2>& radii_m,
               float step_m) {
    const Eigen::Vector3f axis = (b - a).normalized();
    const Eigen::Vector3f side = axis.unitOrthogonal();
    const Eigen::Vector3f other = axis.cross(side);
    const int around = std::max(7, num_steps(2.0F * kPi * radii_m[0], step_m));
    const int along = num_steps((b - a).norm(), step_m) + 2;
    add_grid(shape, around, along, [&](float u, float v) -> Eigen::Vector3f {
        const float angle = 2.0F * kPi * u;
        const float row = v * static_cast<float>(along);
        const float straight = static_cast<float>(along - 2);
        const float s = std::min(1.0F, row / straight);
        // From 0 to 1 over the rounded end.
        const float cap = std::max(0.0F, (row - straight) / 2.0F);
        const float r = (radii_m[0] + (radii_m[1] - radii_m[0]) * s) * std::cos(cap * kPi / 2.0F);
        const Eigen::Vector3f middle =
            a + s * (b - a) + std::sin(cap * kPi / 2.0F) * radii_m[1] * axis;
        return middle + r * (std::cos(angle) * side + std::sin(angle) * other);
    });
}

}  // namespace

Shape make_box(const Eigen::Vector3f& size_m, float step_m) {
    Shape shape;
    for (const Face& face : kFaces)
        add_grid(shape,
                 num_steps(size_m[face.u], step_m),
                 num_steps(size_m[face.v], step_m),
                 [&](float u, float v) -> Eigen::Vector3f {
                     return 0.5F * size_m.cwiseProduct(on_cube(face, u, v));
                 });
    return shape;
}

Shape make_cylinder(float radius_m, float height_m, float step_m) {
    Shape shape;
    // A multiple of four, so that the ends of the diameters along x and y are vertices.
    const int around = 4 * std::max(6, num_steps(0.5F * kPi * radius_m, step_m));
    const int across = num_steps(radius_m, step_m);
    const auto ring = [&](float u, float r, float z) {
        const float angle = 2.0F * kPi * u;
        return Eigen::Vector3f(r * std::cos(angle), r * std::sin(angle), z);
    };
    add_grid(shape, around, num_steps(height_m, step_m), [&](float u, float v) {
        return ring(u, radius_m, v * height_m);
    });
    add_grid(shape, around, across, [&](float u, float v) {
        return ring(u, radius_m * (1.0F - v), height_m);
    });
    add_grid(shape, around, across, [&](float u, float v) { return ring(u, radius_m * v, 0.0F); });
    return shape;
}

Shape make_ellipsoid(const Eigen::Vector3f& radii_m, float step_m) {
    Shape shape;
    const int num_cells = std::max(4, num_steps(0.5F * kPi * radii_m.maxCoeff(), step_m));
    for (const Face& face : kFaces)
        add_grid(shape, num_cells, num_cells, [&](float u, float v) -> Eigen::Vector3f {
            return radii_m.cwiseProduct(on_cube(face, u, v).normalized());
        });
    return shape;
}

Shape make_height_field(const Rectangle& area,
                        float step_m,
                        const std::function<float(float, float)>& height,
                        const std::function<bool(float, float)>& leave_out) {
    Shape shape;
    add_grid(shape,
             num_steps(area.max_x - area.min_x, step_m),
             num_steps(area.max_y - area.min_y, step_m),
             [&](float u, float v) {
                 const float x = area.min_x + u * (area.max_x - area.min_x);
                 const float y = area.min_y + v * (area.max_y - area.min_y);
                 return Eigen::Vector3f(x, y, height(x, y));
             });
    if (leave_out)
        std::erase_if(shape.triangles, [&](const std::array<std::uint32_t, 3>& triangle) {
            const Eigen::Vector3f center =
                (shape.vertices[triangle[0]] + shape.vertices[triangle[1]] +
                 shape.vertices[triangle[2]]) /
                3.0F;
            return leave_out(center.x(), center.y());
        });
    return shape;
}

Shape make_branches(float height_m, int num_arms, float step_m, std::uint64_t seed) {
    struct Arm {
        Eigen::Vector3f foot;
        Eigen::Vector3f direction;
        float length_m;
        int level;
    };
    base::RandomRow random(seed);
    const auto jitter = [&](float amount) {
        const auto draw = [&] { return static_cast<float>(random.uniform(-amount, amount)); };
        const float x = draw();
        const float y = draw();
        return Eigen::Vector3f(x, y, draw());
    };
    std::vector<Arm> arms;
    for (int i = 0; i < num_arms; ++i) {
        const Eigen::Vector3f direction = Eigen::Vector3f(0, 0, 0.9F) + jitter(0.8F);
        arms.push_back({0.03F * jitter(1.0F), direction.normalized(), 0.5F * height_m, 0});
    }
    Shape shape;
    while (!arms.empty()) {
        const Arm arm = arms.back();
        arms.pop_back();
        const Eigen::Vector3f tip = arm.foot + arm.length_m * arm.direction;
        const float thick_m = 0.075F * height_m / static_cast<float>(1 + arm.level);
        add_stick(shape, arm.foot, tip, {thick_m, 0.7F * thick_m}, step_m);
        for (int fork = 0; arm.level < 2 && fork < 2; ++fork)
            arms.push_back(
                {tip,
                 (arm.direction + jitter(0.7F) + Eigen::Vector3f(0, 0, 0.2F)).normalized(),
                 0.62F * arm.length_m,
                 arm.level + 1});
    }
    return shape;
}

void append(Shape& shape, const Shape& other) {
    const auto offset = static_cast<std::uint32_t>(shape.vertices.size());
    shape.vertices.insert(shape.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles)
        shape.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

void roughen(Shape& shape, const NoiseField& noise, float amplitude_m, float wavelength_m) {
    for (Eigen::Vector3f& p : shape.vertices)
        p += amplitude_m * noise.fractal(p, wavelength_m, 3).head<3>().matrix();
}

}  // namespace divemesh::simulator
