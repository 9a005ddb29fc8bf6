#include "worker/calibration/row_jump.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::calibration {
namespace {

constexpr std::size_t kMinMatchesOfPair = 8;
// Pairs on either side of a place that are compared: a quarter of all, as many as there are at an
// end.
constexpr std::size_t kMinPairs = 2;
constexpr std::size_t kMinReach = 3;
constexpr std::size_t kMaxReach = 8;
constexpr double kMinScale_px = 0.5;  // of the robust cost
constexpr double kScale_rad = 1e-3;
constexpr double kMinShift_px = 0.5;
constexpr double kMinShift_rad = 8e-4;
constexpr double kMinScatters = 5.0;
constexpr double kMaxAstray = 0.1;  // share of the pairs that are nearer to the other side
// Priors, in focal lengths over focal lengths: a roll of a degree, a baseline off by as much.
constexpr double kSlopeSigma = 0.0175;
constexpr double kTiny = 1e-9;
constexpr int kNumSteps = 16;
constexpr int kSharesOfGrid = 4;      // of a jump
constexpr double kFirstScales = 8.0;  // the scale shrinks to one of them

using Model = RowJump::Model;

// What rows depend on, and the offset, of one match.
struct Sample {
    Model place;
    double offset_px = 0.0;
};
struct Pair {
    int frame = 0;
    std::vector<Sample> samples;
};
using Pairs = std::vector<Pair>;

std::vector<Sample> samples_of(const types::RectifiedRig& rig,
                               const types::StereoMatches& matches) {
    std::vector<Sample> samples;
    for (const types::StereoMatch& match : matches) {
        const Eigen::Vector3d ray = rig.point_cam(match.left_px.x(), match.left_px.y(), 1.0);
        const double disparity_px = match.left_px.x() - match.right_px.x();
        samples.push_back({{ray.x(), ray.y(), 1.0, disparity_px / rig.focal_px},
                           match.right_px.y() - match.left_px.y()});
    }
    return samples;
}

Pairs pairs_of(const types::RectifiedRig& rig, const types::StereoMatches& matches) {
    std::map<int, types::StereoMatches> by_frame;
    for (const types::StereoMatch& match : matches) by_frame[match.frame_index].push_back(match);
    Pairs pairs;
    for (const auto& [frame, of_pair] : by_frame)
        if (of_pair.size() >= kMinMatchesOfPair) pairs.push_back({frame, samples_of(rig, of_pair)});
    return pairs;
}

double scale_px(const types::RectifiedRig& rig) {
    return std::max(kMinScale_px, kScale_rad * rig.focal_px);
}

double error_px(const Sample& sample, const Model& model) {
    return sample.offset_px - model.dot(sample.place);
}

// The cost of an error (Geman and McClure 1987), 0 to 1.
double cost_of(double error_px, double scale_px) {
    const double square = error_px * error_px;
    return square / (square + scale_px * scale_px);
}

double cost_of(const std::vector<Sample>& samples, const Model& model, double scale_px) {
    double cost = 0.0;
    for (const Sample& sample : samples) cost += cost_of(error_px(sample, model), scale_px);
    return cost;
}

double median_offset_px(const Pairs& pairs, std::size_t begin, std::size_t end) {
    std::vector<double> offsets_px;
    for (std::size_t i = begin; i < end; ++i)
        for (const Sample& sample : pairs[i].samples) offsets_px.push_back(sample.offset_px);
    return stats::upper_median(std::move(offsets_px));
}

// The rows of the pairs before and after a place between two of them.
struct Sides {
    Pairs pairs;
    std::size_t split = 0;  // the first of `pairs` that lies after
    std::array<Model, 2> models;
    double cost = 0.0;
    double cost_as_one = 0.0;  // with the same rows on both sides

    const Model& model_of(std::size_t pair) const { return models[pair < split ? 0 : 1]; }
    double gain() const { return cost_as_one - cost; }
};

// Solves for x, y and offset of both sides and the slope by disparity that they share (reweighted
// least squares), with the scale of the weights shrinking to `scale_px`.
std::array<Model, 2> fit(const Pairs& pairs, std::size_t split, double focal_px, double scale_px) {
    constexpr int kSize = 7;
    using Vector = Eigen::Matrix<double, kSize, 1>;
    using Matrix = Eigen::Matrix<double, kSize, kSize>;
    Vector values = Vector::Zero();
    values[2] = median_offset_px(pairs, 0, split);
    if (split < pairs.size()) values[5] = median_offset_px(pairs, split, pairs.size());
    const auto model_of = [&](std::size_t side) -> Model {
        const auto at = static_cast<Eigen::Index>(3 * side);
        return {values[at], values[at + 1], values[at + 2], values[6]};
    };
    const double prior = scale_px * scale_px / std::pow(kSlopeSigma * focal_px, 2);
    Vector priors;
    priors << prior, prior, kTiny, prior, prior, kTiny, prior;
    for (int step = 0; step < kNumSteps; ++step) {
        const double left = 1.0 - static_cast<double>(step) / (kNumSteps - 2);
        const double scale = scale_px * std::pow(kFirstScales, std::max(0.0, left));
        Matrix information = priors.asDiagonal();
        Vector gradient = Vector::Zero();
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const std::size_t side = i < split ? 0 : 1;
            const Model model = model_of(side);
            for (const Sample& sample : pairs[i].samples) {
                const double weight = std::pow(1.0 - cost_of(error_px(sample, model), scale), 2);
                Vector row = Vector::Zero();
                row.segment<3>(static_cast<Eigen::Index>(3 * side)) = sample.place.head<3>();
                row[6] = sample.place[3];
                information += weight * row * row.transpose();
                gradient += weight * sample.offset_px * row;
            }
        }
        values = information.ldlt().solve(gradient);
    }
    return {model_of(0), model_of(1)};
}

double cost_of(const Sides& sides, double scale_px) {
    double cost = 0.0;
    for (std::size_t i = 0; i < sides.pairs.size(); ++i)
        cost += cost_of(sides.pairs[i].samples, sides.model_of(i), scale_px);
    return cost;
}

Sides sides_of(const Pairs& pairs, std::size_t split, double focal_px, double scale_px) {
    const std::size_t reach = std::clamp(pairs.size() / 4, kMinReach, kMaxReach);
    const std::size_t begin = split - std::min(split, reach);
    const std::size_t end = std::min(pairs.size(), split + reach);
    const auto at = [&](std::size_t i) { return pairs.begin() + static_cast<std::ptrdiff_t>(i); };
    Sides sides{{at(begin), at(end)}, split - begin, {}, 0.0, 0.0};
    sides.models = fit(sides.pairs, sides.pairs.size(), focal_px, scale_px);
    sides.models[1] = sides.models[0];
    sides.cost_as_one = cost_of(sides, scale_px);
    sides.models = fit(sides.pairs, sides.split, focal_px, scale_px);
    sides.cost = cost_of(sides, scale_px);
    return sides;
}

// Returns the RMS over all samples of what the sides differ by.
double shift_px(const Sides& sides) {
    double squares = 0.0;
    std::size_t num = 0;
    for (const Pair& pair : sides.pairs)
        for (const Sample& sample : pair.samples) {
            squares += std::pow((sides.models[1] - sides.models[0]).dot(sample.place), 2);
            ++num;
        }
    return std::sqrt(squares / static_cast<double>(num));
}

// Returns what the rows of whole pairs differ by on their own side: robust standard deviation of
// their median errors.
double scatter_px(const Sides& sides) {
    std::vector<double> sizes_px;
    for (std::size_t i = 0; i < sides.pairs.size(); ++i) {
        std::vector<double> errors_px;
        for (const Sample& sample : sides.pairs[i].samples)
            errors_px.push_back(error_px(sample, sides.model_of(i)));
        sizes_px.push_back(std::abs(stats::upper_median(std::move(errors_px))));
    }
    return stats::kSigmasPerMad * stats::upper_median(std::move(sizes_px));
}

double share_astray(const Sides& sides, double scale_px) {
    std::size_t num = 0;
    for (std::size_t i = 0; i < sides.pairs.size(); ++i) {
        const std::size_t side = i < sides.split ? 0 : 1;
        const auto cost = [&](std::size_t as) {
            return cost_of(sides.pairs[i].samples, sides.models[as], scale_px);
        };
        if (cost(1 - side) < cost(side)) ++num;
    }
    return static_cast<double>(num) / static_cast<double>(sides.pairs.size());
}

// Moves the place between the pairs to where both models fit best.
void settle(Sides& sides, double scale_px) {
    std::vector<double> gains;  // of each pair, if it lies before
    for (const Pair& pair : sides.pairs)
        gains.push_back(cost_of(pair.samples, sides.models[1], scale_px) -
                        cost_of(pair.samples, sides.models[0], scale_px));
    double gain = 0.0;
    double best = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < gains.size(); ++i) {
        gain += gains[i - 1];
        if (gain <= best) continue;
        best = gain;
        sides.split = i;
    }
}

bool is_jump(const Sides& sides, double focal_px, double scale_px) {
    const double shift = shift_px(sides);
    return shift >= std::max(kMinShift_px, kMinShift_rad * focal_px) &&
           shift >= kMinScatters * scatter_px(sides) && share_astray(sides, scale_px) <= kMaxAstray;
}

}  // namespace

std::optional<bool> RowJump::is_before(const types::StereoMatches& matches) const {
    if (matches.size() < kMinMatchesOfPair) return std::nullopt;
    const std::vector<Sample> samples = samples_of(rig, matches);
    const double scale = scale_px(rig);
    return cost_of(samples, before, scale) < cost_of(samples, after, scale);
}

std::optional<double> RowJump::share_after(const types::StereoMatches& matches) const {
    if (matches.size() < kMinMatchesOfPair) return std::nullopt;
    const std::vector<Sample> samples = samples_of(rig, matches);
    const double scale = scale_px(rig);
    const auto at = [&](double share) -> Model { return before + share * (after - before); };
    double best = 0.0;
    for (int i = -kSharesOfGrid; i <= 2 * kSharesOfGrid; ++i) {
        const double share = static_cast<double>(i) / kSharesOfGrid;
        if (cost_of(samples, at(share), scale) < cost_of(samples, at(best), scale)) best = share;
    }
    for (int step = 0; step < kNumSteps; ++step) {
        double information = kTiny;
        double gradient = 0.0;
        for (const Sample& sample : samples) {
            const double error = error_px(sample, at(best));
            const double weight = std::pow(1.0 - cost_of(error, scale), 2);
            const double moved = (after - before).dot(sample.place);
            information += weight * moved * moved;
            gradient += weight * moved * error;
        }
        best += gradient / information;
    }
    return best;
}

std::optional<RowJump> find_row_jump(const types::RectifiedRig& rig,
                                     const types::StereoMatches& matches) {
    const Pairs pairs = pairs_of(rig, matches);
    const double scale = scale_px(rig);
    std::optional<Sides> best;
    for (std::size_t i = kMinPairs; i + kMinPairs <= pairs.size(); ++i) {
        Sides sides = sides_of(pairs, i, rig.focal_px, scale);
        if ((!best || sides.gain() > best->gain()) && is_jump(sides, rig.focal_px, scale))
            best = std::move(sides);
    }
    if (!best) return std::nullopt;
    settle(*best, scale);
    return RowJump{best->pairs[best->split - 1].frame,
                   best->pairs[best->split].frame,
                   shift_px(*best),
                   rig,
                   best->models[0],
                   best->models[1]};
}

}  // namespace divemesh::calibration
