#pragma once

#include <Eigen/Core>
#include <vector>

namespace divemesh::reef {

// Corners in order, m; the last is joined to the first. Not self-crossing, either orientation.
using Polygon = std::vector<Eigen::Vector2d>;

double area_m2(const Polygon& polygon);  // never negative

// Returns whether two sides that are not neighbours have a point in common, or one has no length.
bool is_self_crossing(const Polygon& polygon);

// Returns whether a point is inside, or on the border with a tolerance of a nanometre.
bool contains(const Polygon& polygon, const Eigen::Vector2d& point);

// Returns the distance of the two corners that are farthest apart (the major diameter of a colony).
double max_diameter_m(const Polygon& polygon);

// Returns the area of the intersection of a triangle and a polygon, which may be concave: the
// polygon clipped by the triangle's three sides (Sutherland and Hodgman 1974).
double overlap_m2(const Polygon& polygon,
                  const Eigen::Vector2d& a,
                  const Eigen::Vector2d& b,
                  const Eigen::Vector2d& c);

}  // namespace divemesh::reef
