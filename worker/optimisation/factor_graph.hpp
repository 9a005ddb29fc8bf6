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

// A block of unknowns. Its values are owned by the caller, and their address identifies it.
struct Block {
    double* values = nullptr;
    int size = 0;
    ceres::Manifold* manifold = nullptr;  // nullptr: a vector
    bool fixed = false;
    Eigen::VectorXd first_estimate;  // linearisation point; empty: the current values

    int tangent_size() const { return manifold ? manifold->TangentSize() : size; }
    const double* linearised_at() const {
        return first_estimate.size() > 0 ? first_estimate.data() : values;
    }
};

// A cost function over some blocks; `loss` may be nullptr.
struct Factor {
    std::unique_ptr<ceres::CostFunction> cost;
    ceres::LossFunction* loss = nullptr;
    std::vector<int> blocks;
};

// An observation of a landmark from a state.
struct StereoFactor {
    StereoReprojection reprojection;
    int rotation = 0;  // index of a block
    int position = 0;
    std::size_t landmark = 0;
};

// A graph of unknowns and the factors that measure them. The cost is a sum of squares; camera
// observations are under `reprojection_loss`.
class FactorGraph {
public:
    explicit FactorGraph(double reprojection_huber) : reprojection_loss_(reprojection_huber) {}

    // Returns the block's index; a block that exists already is not changed.
    int add_block(double* values, int size, ceres::Manifold* manifold = nullptr);
    void fix(double* values);
    // Sets the block's linearisation point.
    void set_first_estimate(double* values, const Eigen::VectorXd& at);
    // Adds a factor; blocks that do not exist yet become vectors. The caller keeps `loss`.
    void add_factor(std::unique_ptr<ceres::CostFunction> cost,
                    ceres::LossFunction* loss,
                    const std::vector<double*>& blocks);
    // Adds an observation; those of one landmark must follow each other.
    void add_observation(const StereoReprojection& reprojection,
                         double* q_world_imu,
                         double* p_world_imu,
                         Eigen::Vector3d& p_world);
    // Removes observations of landmarks that are not in front of the camera.
    void drop_unseen();

    const std::vector<Block>& blocks() const { return blocks_; }
    const std::vector<Factor>& factors() const { return factors_; }
    const std::vector<StereoFactor>& observations() const { return observations_; }
    const std::vector<Eigen::Vector3d*>& landmarks() const { return landmarks_; }
    const ceres::HuberLoss& reprojection_loss() const { return reprojection_loss_; }
    int index_of(const double* values) const { return index_.at(values); }
    bool contains(const double* values) const { return index_.contains(values); }

    // Returns the whole graph as a Ceres problem that refers to this graph. First estimates are
    // ignored.
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
