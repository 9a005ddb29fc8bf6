#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/synthetic/rough_ground.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::bench {

// Ground four times as long as wide with round colonies. Some of them are gone, new or higher in
// the second year. It gives models of any size to compare, with known change.
class ComparedPlace {
public:
    ComparedPlace(unsigned seed, std::size_t num_vertices);

    // Returns the model that a dive of that year would give: vertices 5 mm apart, with noise and a
    // frame of that year.
    types::Mesh model(int year) const;
    // Returns camera positions above the ground, in the frame of that year's model, row after row.
    std::vector<Eigen::Vector3d> eyes(int year) const;
    double heading_rad(int year) const { return year == 1 ? 0.0 : 0.3; }

    double area_m2() const { return 4.0 * half_x_m_ * half_y_m_; }
    double grown_m3() const { return change_m3(1.0); }
    double lost_m3() const { return change_m3(-1.0); }

private:
    struct Colony {
        double x_m, y_m, radius_m;
        double height_m[2];  // by year
    };

    Eigen::Isometry3d T_model_place(int year) const;
    double height_m(double x, double y, int year) const;
    double brightness(double x, double y) const;
    double change_m3(double sign) const;
    const Colony& colony_near(double x, double y) const;

    unsigned seed_;
    double half_x_m_;
    double half_y_m_;
    int num_along_;
    int num_across_;
    synthetic::HeightOf ground_;
    std::vector<Colony> colonies_;  // row by row, each within its own square
};

}  // namespace divemesh::bench
