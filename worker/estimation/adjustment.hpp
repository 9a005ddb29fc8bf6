#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "worker/estimation/gyroscope_integral.hpp"
#include "worker/geometry/rectified_rig.hpp"
#include "worker/observer.hpp"

namespace divemesh::worker {

// The body at a keyframe, as the adjustments estimate it.
struct BodyState {
    Eigen::Quaterniond q_world_imu = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_world_imu = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();  // rad/s

    static BodyState at(const Eigen::Isometry3d& T_world_imu, const Eigen::Vector3d& bias);
    Eigen::Isometry3d T_world_imu() const;
};

// Bundle adjustment: body states and landmarks that fit best what the cameras and the inertial
// sensors measured, by Ceres. States and landmarks belong to the caller, stay where they are until
// solve() has changed them. One thread: the same input gives the same bits.
class Adjustment {
public:
    explicit Adjustment(const RectifiedRig& rig);
    ~Adjustment();
    Adjustment(const Adjustment&) = delete;
    Adjustment& operator=(const Adjustment&) = delete;

    void add_state(BodyState& state, bool fixed);
    void add_observation(BodyState& state,
                         Eigen::Vector3d& p_world,
                         const Eigen::Vector3d& measured_px,
                         const Eigen::Vector3d& sigma_px);
    // The gyroscope between two states; `random_walk` of its bias in rad/s^2/sqrt(Hz).
    void add_turn(BodyState& from,
                  BodyState& to,
                  const GyroscopeIntegral& turn,
                  double random_walk);
    void add_bias(BodyState& state, const Eigen::Vector3d& known, double sigma);
    void fix_bias(BodyState& state);
    void add_orientation(BodyState& state, const Eigen::Quaterniond& q_world_imu, double sigma_rad);

    enum class Size { Window, Dive };
    // Reports `at` to `progress` every iteration. Throws what the callback throws.
    void solve(Size size, int max_iterations, const ProgressCallback& progress, const Progress& at);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::worker
