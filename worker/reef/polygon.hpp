#pragma once

#include <Eigen/Core>
#include <vector>

namespace divemesh::reef {

// Corners in order, the last joined to the first; not self-crossing, either orientation. m.
using Polygon = std::vector<Eigen::Vector2d>;

double area_m2(const Polygon& polygon);  // never negative

// Two sides that are not neighbours have a point in common, or one has no length.
bool is_self_crossing(const Polygon& polygon);

// Within, or on the border up to a nanometre.
bool contains(const Polygon& polygon, const Eigen::Vector2d& point);

// Between the two corners that are farthest from each other (the major diameter of a colony).
double max_diameter_m(const Polygon& polygon);

// Area of what a triangle and the polygon have in common: the polygon clipped by the triangle's
// three sides (Sutherland and Hodgman 1974), which may be concave.
double overlap_m2(const Polygon& polygon,
                  const Eigen::Vector2d& a,
                  const Eigen::Vector2d& b,
                  const Eigen::Vector2d& c);

}  // namespace divemesh::reef
