#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ceres/cost_function.h>
#include <cmath>
#include <memory>
#include <vector>

namespace divemesh::synthetic {

// Expects the derivatives of a cost function to equal central differences of its residuals.
inline void expect_true_jacobians(const ceres::CostFunction& cost,
                                  std::vector<std::vector<double>> blocks) {
    ASSERT_EQ(blocks.size(), cost.parameter_block_sizes().size());
    const auto rows = static_cast<std::size_t>(cost.num_residuals());
    std::vector<double*> parameters;
    for (auto& block : blocks) parameters.push_back(block.data());
    std::vector<double> residuals(rows);
    std::vector<std::vector<double>> stated;
    std::vector<double*> rows_of;
    for (const auto& block : blocks) stated.emplace_back(rows * block.size());
    for (auto& matrix : stated) rows_of.push_back(matrix.data());
    ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), rows_of.data()));
    constexpr double kStep = 1e-6;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        for (std::size_t i = 0; i < blocks[b].size(); ++i) {
            const double value = blocks[b][i];
            std::vector<double> above(rows);
            std::vector<double> below(rows);
            blocks[b][i] = value + kStep;
            ASSERT_TRUE(cost.Evaluate(parameters.data(), above.data(), nullptr));
            blocks[b][i] = value - kStep;
            ASSERT_TRUE(cost.Evaluate(parameters.data(), below.data(), nullptr));
            blocks[b][i] = value;
            for (std::size_t r = 0; r < rows; ++r) {
                const double numeric = (above[r] - below[r]) / (2.0 * kStep);
                EXPECT_NEAR(stated[b][r * blocks[b].size() + i],
                            numeric,
                            1e-4 * std::max(1.0, std::abs(numeric)))
                    << "residual " << r << ", block " << b << ", parameter " << i;
            }
        }
    }
}

}  // namespace divemesh::synthetic
