#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "worker/simulator/noise_field.hpp"

namespace divemesh::simulator {

// Triangles in an object's own coordinates, m; wound counter-clockwise seen from outside.
// Everything is cut into pieces of about `step_m`, so that "what was seen" can be told triangle by
// triangle.
struct Shape {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Centred at the origin; exact flat faces and edges.
Shape make_box(const Eigen::Vector3f& size_m, float step_m);
// Along z, from 0 to `height_m`, with caps; sides are exact only at the vertices.
Shape make_cylinder(float radius_m, float height_m, float step_m);
// A sphere with the given half axes.
Shape make_ellipsoid(const Eigen::Vector3f& radii_m, float step_m);
// z = height(x, y) over a rectangle; cells whose centre `leave_out` names are holes.
struct Rectangle {
    float min_x, max_x, min_y, max_y;
};
Shape make_height_field(const Rectangle& area,
                        float step_m,
                        const std::function<float(float, float)>& height,
                        const std::function<bool(float, float)>& leave_out = {});
// A bush of tapering arms that fork twice; stands on the origin.
Shape make_branches(float height_m, int num_arms, float step_m, std::uint64_t seed);

void append(Shape& shape, const Shape& other);
// Moves vertices by solid noise of up to about `amplitude_m`; keeps closed shapes closed.
void roughen(Shape& shape, const NoiseField& noise, float amplitude_m, float wavelength_m);

}  // namespace divemesh::simulator
