#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "worker/simulator/noise_field.hpp"

namespace divemesh::simulator {

// Triangles in an object's own coordinates, m, wound counter-clockwise seen from outside. All faces
// are divided into triangles of about `step_m`, so that visibility can be stored per triangle.
struct Shape {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Centred at the origin, with exact flat faces and edges.
Shape make_box(const Eigen::Vector3f& size_m, float step_m);
// Along z, from 0 to `height_m`, with caps; the side is exact only at the vertices.
Shape make_cylinder(float radius_m, float height_m, float step_m);
// Centred at the origin, with the given half axes.
Shape make_ellipsoid(const Eigen::Vector3f& radii_m, float step_m);
// z = height(x, y) over a rectangle; cells for whose centre `leave_out` returns true are holes.
struct Rectangle {
    float min_x, max_x, min_y, max_y;
};
Shape make_height_field(const Rectangle& area,
                        float step_m,
                        const std::function<float(float, float)>& height,
                        const std::function<bool(float, float)>& leave_out = {});
// A bush of tapering arms that fork twice; it stands on the origin.
Shape make_branches(float height_m, int num_arms, float step_m, std::uint64_t seed);

// Appends the vertices and triangles of `other`.
void append(Shape& shape, const Shape& other);
// Moves vertices by solid noise of up to about `amplitude_m`; closed shapes stay closed.
void roughen(Shape& shape, const NoiseField& noise, float amplitude_m, float wavelength_m);

}  // namespace divemesh::simulator
