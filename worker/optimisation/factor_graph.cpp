#include "worker/optimisation/factor_graph.hpp"

#include <utility>

namespace divemesh::optimisation {

int FactorGraph::add_block(double* values, int size, ceres::Manifold* manifold) {
    const auto [known, fresh] = index_.try_emplace(values, static_cast<int>(blocks_.size()));
    if (fresh) blocks_.push_back({values, size, manifold, false, {}});
    return known->second;
}

void FactorGraph::fix(double* values) {
    blocks_[static_cast<std::size_t>(index_of(values))].fixed = true;
}

void FactorGraph::set_first_estimate(double* values, const Eigen::VectorXd& at) {
    blocks_[static_cast<std::size_t>(index_of(values))].first_estimate = at;
}

void FactorGraph::add_factor(std::unique_ptr<ceres::CostFunction> cost,
                             ceres::LossFunction* loss,
                             const std::vector<double*>& blocks) {
    Factor factor{std::move(cost), loss, {}};
    const auto& sizes = factor.cost->parameter_block_sizes();
    for (std::size_t i = 0; i < blocks.size(); ++i)
        factor.blocks.push_back(add_block(blocks[i], sizes[i]));
    factors_.push_back(std::move(factor));
}

void FactorGraph::add_observation(const StereoReprojection& reprojection,
                                  double* q_world_imu,
                                  double* p_world_imu,
                                  Eigen::Vector3d& p_world) {
    if (landmarks_.empty() || landmarks_.back() != &p_world) landmarks_.push_back(&p_world);
    observations_.push_back(
        {reprojection, index_of(q_world_imu), index_of(p_world_imu), landmarks_.size() - 1});
}

void FactorGraph::drop_unseen() {
    std::erase_if(observations_, [&](const StereoFactor& seen) {
        Eigen::Vector3d r;
        return !seen.reprojection(blocks_[static_cast<std::size_t>(seen.rotation)].values,
                                  blocks_[static_cast<std::size_t>(seen.position)].values,
                                  landmarks_[seen.landmark]->data(),
                                  r.data());
    });
}

std::unique_ptr<ceres::Problem> FactorGraph::problem() {
    ceres::Problem::Options options;
    options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    auto problem = std::make_unique<ceres::Problem>(options);
    for (const Block& block : blocks_) {
        problem->AddParameterBlock(block.values, block.size, block.manifold);
        if (block.fixed) problem->SetParameterBlockConstant(block.values);
    }
    std::vector<double*> values;
    for (const Factor& factor : factors_) {
        values.clear();
        for (const int block : factor.blocks)
            values.push_back(blocks_[static_cast<std::size_t>(block)].values);
        problem->AddResidualBlock(factor.cost.get(), factor.loss, values);
    }
    reprojection_costs_.clear();
    for (const StereoFactor& seen : observations_) {
        reprojection_costs_.emplace_back(StereoReprojection::create(seen.reprojection));
        problem->AddResidualBlock(reprojection_costs_.back().get(),
                                  &reprojection_loss_,
                                  blocks_[static_cast<std::size_t>(seen.rotation)].values,
                                  blocks_[static_cast<std::size_t>(seen.position)].values,
                                  landmarks_[seen.landmark]->data());
    }
    return problem;
}

}  // namespace divemesh::optimisation
