#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/surface_color.hpp"

namespace divemesh::simulator {

// A fish that circles a place in front of the diver: a moving object that must not be taken for the
// scene. A body and a beating tail, both ellipsoids.
class Fish {
public:
    struct Shape {  // at one moment
        struct Part {
            Eigen::Matrix3f unit_world;  // world to a sphere of radius 1
            Eigen::Vector3f center_world;
        };
        std::vector<Part> parts;
        Eigen::Vector3f center_world = Eigen::Vector3f::Zero();
        float radius_m = 0.0F;  // of its bounding sphere
        std::uint64_t seed = 0;
    };
    struct Hit {
        float t = 0.0F;
        Eigen::Vector3f normal_world = Eigen::Vector3f::UnitZ();
        Rgb color = Rgb::Zero();
    };

    // Returns a school along the path of `motion`, about one fish for every four seconds times
    // `density`.
    static std::vector<Fish> make_school(const DiverMotion& motion,
                                         double duration_s,
                                         const Eigen::Vector3d& look_imu,
                                         double density,
                                         std::uint64_t seed);

    Shape at(double t_s) const;
    static std::optional<Hit> intersect(const Shape& shape,
                                        const Eigen::Vector3f& origin,
                                        const Eigen::Vector3f& direction);

private:
    Eigen::Vector3d center_world_ = Eigen::Vector3d::Zero();
    double radius_x_m_ = 0.4;
    double radius_y_m_ = 0.4;
    double rise_m_ = 0.05;
    double rate_ = 0.7;  // rad/s round the circle
    double phase_ = 0.0;
    double length_m_ = 0.16;
    std::uint64_t seed_ = 0;
};

}  // namespace divemesh::simulator
