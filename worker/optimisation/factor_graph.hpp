#pragma once

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <cstddef>
#include <memory>
#include <unordered_map>
#include <vector>

#include "worker/optimisation/residuals/stereo_reprojection.hpp"

namespace divemesh::optimisation {

// Unknown numbers. They lie where the caller has them, and are known by that.
struct Block {
    double* values = nullptr;
    int size = 0;
    ceres::Manifold* manifold = nullptr;  // nullptr: a vector
    bool fixed = false;
    Eigen::VectorXd first_estimate;  // where derivatives are taken; empty: where it is now

    int tangent_size() const { return manifold ? manifold->TangentSize() : size; }
    const double* linearised_at() const {
        return first_estimate.size() > 0 ? first_estimate.data() : values;
    }
};

struct Factor {
    std::unique_ptr<ceres::CostFunction> cost;
    ceres::LossFunction* loss = nullptr;
    std::vector<int> blocks;
};

// A landmark as a state saw it.
struct StereoFactor {
    StereoReprojection reprojection;
    int rotation = 0;  // blocks
    int position = 0;
    std::size_t landmark = 0;
};

// Unknowns, and what was measured of them: sums of squares, cameras' under `reprojection_loss`.
class FactorGraph {
public:
    explicit FactorGraph(double reprojection_huber) : reprojection_loss_(reprojection_huber) {}

    // Its index. One that is known already stays as it is.
    int add_block(double* values, int size, ceres::Manifold* manifold = nullptr);
    void fix(double* values);
    // Derivatives by a block are taken there from now on.
    void set_first_estimate(double* values, const Eigen::VectorXd& at);
    // Blocks that are not known yet are vectors. `loss` stays the caller's.
    void add_factor(std::unique_ptr<ceres::CostFunction> cost,
                    ceres::LossFunction* loss,
                    const std::vector<double*>& blocks);
    // Observations of one landmark are added after one another.
    void add_observation(const StereoReprojection& reprojection,
                         double* q_world_imu,
                         double* p_world_imu,
                         Eigen::Vector3d& p_world);
    // Observations of what is not in front of the camera.
    void drop_unseen();

    const std::vector<Block>& blocks() const { return blocks_; }
    const std::vector<Factor>& factors() const { return factors_; }
    const std::vector<StereoFactor>& observations() const { return observations_; }
    const std::vector<Eigen::Vector3d*>& landmarks() const { return landmarks_; }
    const ceres::HuberLoss& reprojection_loss() const { return reprojection_loss_; }
    int index_of(const double* values) const { return index_.at(values); }
    bool contains(const double* values) const { return index_.contains(values); }

    // All of it as a problem for Ceres, which refers to this graph. First estimates are not heeded.
    std::unique_ptr<ceres::Problem> problem();

private:
    std::vector<Block> blocks_;
    std::vector<Factor> factors_;
    std::vector<StereoFactor> observations_;
    std::vector<Eigen::Vector3d*> landmarks_;
    std::unordered_map<const double*, int> index_;
    std::vector<std::unique_ptr<ceres::CostFunction>> reprojection_costs_;  // for Ceres
    ceres::HuberLoss reprojection_loss_;
};

}  // namespace divemesh::optimisation
