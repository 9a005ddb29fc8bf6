#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/color/fit_equations.hpp"
#include "worker/color/sighting.hpp"
#include "worker/color/water_unknowns.hpp"

namespace divemesh::color {

// The noise of a sighting before it is scaled to the data, standard deviations: of dark pixels (one
// level of an 8 bit image at 5 % of white), and the share of the light by which texture,
// caustics and errors of the pose change it.
inline constexpr double kDarkNoise = 0.0015;
inline constexpr double kNoiseShare = 0.08;
// Light of which there is a logarithm, and which tells of its water: level 18 of 255.
inline constexpr double kMinLight = 0.003;

// A solved problem.
struct FitSolution {
    bool has_converged = false;  // else no step lowers the loss, or it still falls after the last
    WaterUnknowns unknowns;
    // Covariances of each channel's unknowns, in order; 0 for those that the model does not have.
    std::array<Eigen::Matrix4d, 3> covariances;
    std::vector<std::array<double, 3>> colors;  // of the points
    std::array<double, 3> noise = {};           // times kDarkNoise and kNoiseShare

    // Returns the standard deviation of a linear function of a channel's unknowns; infinity if it
    // is not known.
    double sigma(std::size_t channel, const Eigen::Vector4d& gradient) const;
};

// The robust fit of water, gains and vignetting to sightings: Gauss-Newton with the damping of
// Levenberg and Marquardt and Tukey's weights, the colour of each point eliminated, unknowns at
// their bounds held there (active set). Weak priors decide what the sightings do not tell;
// fit_priors.cpp has their values.
class FitProblem {
public:
    // The points are summed in as many parts, so that sums do not depend on the threads.
    static constexpr std::size_t kNumParts = 16;

    // Refers to `sightings`, which must not be empty. The result does not depend on `num_threads`.
    FitProblem(const Sightings& sightings, int num_threads);

    // Reports progress before each step; throws Error{Cancelled} if `progress` does.
    FitSolution solve(const FitModel& model,
                      const WaterUnknowns& start,
                      const base::ProgressShare& progress) const;

    // Returns the mean of Tukey's loss for a given noise, by which models are compared.
    double loss(const FitModel& model,
                const FitSolution& solution,
                const std::array<double, 3>& noise) const;
    // Returns the logarithm of each sighting's light less that of the model, in one channel, where
    // there is light enough for it.
    std::vector<double> log_residuals(const FitModel& model,
                                      const FitSolution& solution,
                                      std::size_t channel) const;

private:
    struct State : FitSolution {
        std::vector<std::array<double, 3>> weights = {};  // of the sightings
    };
    enum class StepEnd { Lower, Converged, Stalled };

    // Calls visit(sighting index) for all of them, on several threads.
    void for_each_sighting(const std::function<void(std::size_t)>& visit) const;
    // Calls visit(part, point) for all points, on several threads; those of a part are on one.
    void for_each_point(const std::function<void(std::size_t, std::size_t)>& visit) const;
    Prediction predicted(const FitModel& model,
                         const FitSolution& solution,
                         std::size_t sighting,
                         std::size_t channel,
                         double color) const;
    double error(const FitModel& model,
                 const FitSolution& solution,
                 std::size_t sighting,
                 std::size_t channel,
                 double& sigma) const;

    void start_colors(const FitModel& model, State& state) const;
    void estimate_noise(const FitModel& model, State& state) const;
    void weigh(const FitModel& model, State& state) const;
    void solve_colors(const FitModel& model, State& state) const;
    double weighted_loss(const FitModel& model,
                         const FitColumns& columns,
                         const State& state) const;
    PointEquations equations_of(const FitModel& model,
                                const State& state,
                                const FitColumns& columns,
                                std::size_t point,
                                std::size_t channel) const;
    // Returns those of the sightings alone.
    NormalEquations equations(const FitModel& model,
                              const State& state,
                              const FitColumns& columns) const;
    StepEnd step(const FitModel& model,
                 const FitColumns& columns,
                 double& damping,
                 State& state) const;

    std::array<double, 3> huber_factors(const FitModel& model, const State& state) const;
    Eigen::MatrixXd covariance(const FitModel& model,
                               const FitColumns& columns,
                               const State& state,
                               const std::array<double, 3>& factors,
                               const std::vector<int>& held) const;
    void set_covariances(const FitModel& model, const FitColumns& columns, State& state) const;

    const Sightings& sightings_;
    int num_threads_;
    std::vector<std::size_t> begin_;  // of each point, in the sightings
};

}  // namespace divemesh::color
