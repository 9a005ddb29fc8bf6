#include "worker/compare/change_patches.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "worker/compare/change_sums.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

constexpr double kBlock_m = 0.15;  // over which noise is small against the change it hides

// Returns the number of standard deviations that a normal error exceeds, on either side, with this
// probability.
double exceeded_with(double probability) { return -stats::normal_quantile(0.5 * probability); }

double compared_m2(const ChangeMap& map) {
    return cv::countNonZero(cells_with_value(map.change_m)) * map.grid.cell_m * map.grid.cell_m;
}

// Returns a mask (CV_8U) of cells whose change is larger than that of any ground by chance.
cv::Mat beyond_chance(const ChangeMap& map, double ground_m2, double core_m2) {
    const double max_sigmas = exceeded_with(0.05 / std::max(1.0, ground_m2 / core_m2));
    const cv::Mat level = max_sigmas * (map.sigma_m + map.registration_m);
    return cv::abs(map.change_m) > level;
}

cv::Mat cells_in(const ChangeMap& map, CellState state) {
    return map.state == static_cast<int>(state);
}

// Returns the cells with the ground that they enclose, as far as both dives saw it.
cv::Mat filled(const cv::Mat& cells, const cv::Mat& allowed) {
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(cells.clone(), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::Mat full = cv::Mat::zeros(cells.size(), CV_8U);
    cv::drawContours(full, outlines, -1, cv::Scalar::all(255), cv::FILLED);
    return full & allowed;
}

struct Undetected {
    double rise_m3 = 0.0;
    double fall_m3 = 0.0;
};

// Blocks that rose, or those that fell.
struct Blocks {
    double volume_m3 = 0.0;                 // positive
    Vector6d by_motion = Vector6d::Zero();  // as in ChangeSums
};

// Returns upper bounds of the rise and the fall of the blocks beyond what their noise alone would
// show. Half of the errors are a rise: the positive part of a normal error has the mean
// s / sqrt(2 pi). The co-registration moves all blocks that rose by one motion: its tilt matters as
// far as they lie to one side of the pivot, not as if it raised every block.
Undetected undetected(const ChangeMap& map, const cv::Mat& counts, const ChangeNoise& noise) {
    constexpr double kMeanPart = 0.398942;
    constexpr double kVariancePart = 0.5 - kMeanPart * kMeanPart;
    const int side = std::max(1, static_cast<int>(std::lround(kBlock_m / map.grid.cell_m)));
    const cv::Rect all(0, 0, counts.cols, counts.rows);
    Blocks rose;
    Blocks fell;
    double expected_m3 = 0.0;
    double variance = 0.0;
    for (int top = 0; top < counts.rows; top += side)
        for (int left = 0; left < counts.cols; left += side) {
            const cv::Rect block = cv::Rect(left, top, side, side) & all;
            const ChangeSums of_block = sum_over(window_of(map, block), counts(block));
            const double noise_of_block_m3 = noise_m3(of_block, noise);
            Blocks& blocks = of_block.volume_m3 > 0.0 ? rose : fell;
            blocks.volume_m3 += std::abs(of_block.volume_m3);
            blocks.by_motion += of_block.by_motion;
            expected_m3 += kMeanPart * noise_of_block_m3;
            variance += kVariancePart * noise_of_block_m3 * noise_of_block_m3;
        }
    const auto bound = [&](const Blocks& blocks) {
        const double sigma_m3 =
            std::hypot(std::sqrt(variance), map.registration_sigma(blocks.by_motion));
        return std::max(0.0, blocks.volume_m3 - expected_m3) + stats::kNormal975 * sigma_m3;
    };
    return {bound(rose), bound(fell)};
}

// A patch as found, in a window of the map.
struct Found {
    bool grown = false;
    cv::Rect window;
    cv::Mat core;     // CV_8U, of the window: significant cells and what they enclose
    cv::Mat support;  // CV_8U, of the window: cells of the volume
};

class Gatherer {
public:
    Gatherer(ChangeMap& map, const PatchOptions& options)
        : map_(map),
          options_(options),
          margin_cells_(options.margin_m / map.grid.cell_m),
          ground_m2_(compared_m2(map)) {}

    Changes gather() {
        beyond_chance_ = beyond_chance(map_, ground_m2_, options_.core_area_m2);
        for (const CellState state : {CellState::Grown, CellState::Lost}) find(state);
        changes_.number = cv::Mat::zeros(map_.state.size(), CV_32S);
        std::ranges::stable_sort(found_, [&](const Found& p, const Found& q) {
            return std::abs(volume_of(p)) > std::abs(volume_of(q));
        });
        for (std::size_t i = 0; i < found_.size(); ++i) claim(i);
        measure_rest();
        for (std::size_t i = 0; i < found_.size(); ++i) measure(i);
        total();
        return std::move(changes_);
    }

private:
    double volume_of(const Found& found) const {
        return sum_over(window_of(found.window), found.core).volume_m3;
    }
    ChangeMap window_of(const cv::Rect& window) const { return compare::window_of(map_, window); }

    void find(CellState state) {
        cv::Mat labels;
        cv::Mat statistics;
        cv::Mat centers;
        const int num = cv::connectedComponentsWithStats(
            cells_in(map_, state), labels, statistics, centers, 8, CV_32S);
        const double cell_m2 = map_.grid.cell_m * map_.grid.cell_m;
        const int border = static_cast<int>(std::ceil(margin_cells_)) + 2;
        const cv::Rect all(0, 0, map_.state.cols, map_.state.rows);
        for (int label = 1; label < num; ++label) {
            if (statistics.at<int>(label, cv::CC_STAT_AREA) * cell_m2 < options_.least_area_m2)
                continue;
            const cv::Rect window =
                cv::Rect(statistics.at<int>(label, cv::CC_STAT_LEFT) - border,
                         statistics.at<int>(label, cv::CC_STAT_TOP) - border,
                         statistics.at<int>(label, cv::CC_STAT_WIDTH) + 2 * border,
                         statistics.at<int>(label, cv::CC_STAT_HEIGHT) + 2 * border) &
                all;
            const cv::Mat mine = labels(window) == label;
            if (cv::countNonZero(mine & beyond_chance_(window)) * cell_m2 < options_.core_area_m2)
                continue;
            const cv::Mat opposite = cells_in(
                map_, state == CellState::Grown ? CellState::Lost : CellState::Grown)(window);
            const cv::Mat hidden = cells_in(map_, CellState::Hidden)(window);
            const cv::Mat both =
                (map_.change_m(window) == map_.change_m(window)) & ~opposite & ~hidden;
            const cv::Mat core = filled(mine, both);
            cv::Mat support;
            cv::dilate(core, support, disc(margin_cells_));
            found_.push_back({state == CellState::Grown, window, core, support & both});
        }
    }

    // Assigns each cell to one patch: cores first, then the larger patch.
    void claim(std::size_t i) {
        Found& found = found_[i];
        cv::Mat number = changes_.number(found.window);
        for (std::size_t k = 0; k < found_.size(); ++k) {
            if (k == i) continue;
            const cv::Rect both = found.window & found_[k].window;
            if (both.empty()) continue;
            const cv::Mat theirs =
                (k < i ? found_[k].support : found_[k].core)(both - found_[k].window.tl());
            cv::Mat ours = found.support(both - found.window.tl());
            ours.setTo(cv::Scalar::all(0), theirs & ~found.core(both - found.window.tl()));
        }
        number.setTo(cv::Scalar::all(static_cast<double>(i + 1)), found.support);
    }

    void measure_rest() {
        const cv::Mat counts = cells_with_value(map_.change_m) & (changes_.number == 0) &
                               ~cells_in(map_, CellState::Hidden);
        changes_.noise = measure_noise(map_, counts);
        const Undetected missed = undetected(map_, counts, changes_.noise);
        changes_.grown.undetected_m3 = missed.rise_m3;
        changes_.lost.undetected_m3 = missed.fall_m3;
        const ChangeSums sums = sum_over(map_, counts);
        changes_.rest_m2 = sums.area_m2;
        changes_.rest_m3 = interval(sums.volume_m3,
                                    noise_m3(sums, changes_.noise),
                                    map_.registration_sigma(sums.by_motion));
        const int num_beyond = cv::countNonZero(
            (cells_in(map_, CellState::Grown) | cells_in(map_, CellState::Lost)) & counts);
        changes_.beyond_share = num_beyond / std::max(1.0, cv::countNonZero(counts) * 1.0);
        map_.state.setTo(cv::Scalar::all(static_cast<double>(CellState::Stable)), counts);
    }

    // Returns the standard deviation of the volume if the outline's bounds hold with 95 %. The mesh
    // rounds off or fills the foot of steep objects, in the same way everywhere.
    static double outline_m3(const stats::Estimate& area_m2, const ChangeSums& sums) {
        return std::abs(sums.volume_m3) / std::max(1e-12, area_m2.value) * 0.5 *
               (area_m2.high - area_m2.low) / stats::kNormal975;
    }
    void measure(std::size_t i) {
        const Found& found = found_[i];
        const ChangeMap window = window_of(found.window);
        const double sign = found.grown ? 1.0 : -1.0;
        ChangeSums sums = sum_over(window, found.support);
        if (sign * sums.volume_m3 <= 0.0)
            sums = sum_over(window, found.core);  // the support has the opposite sign
        ChangePatch patch;
        patch.number = static_cast<int>(i) + 1;
        patch.grown = found.grown;
        patch.area_m2 = area_of(found);
        const double outline = outline_m3(patch.area_m2, sums);
        const double common = map_.registration_sigma(sums.by_motion) + outline;
        patch.num_sigma = num_sigma(sums.area_m2);
        const double value = sign * sums.volume_m3;
        const double half = patch.num_sigma * std::hypot(noise_m3(sums, changes_.noise), common);
        patch.volume_m3 = {value, value - half, value + half};
        patch.volume_m3.low = std::max(0.0, patch.volume_m3.low);
        patch.mean_change_m = sums.volume_m3 / std::max(1e-12, sums.area_m2);
        patch.largest_change_m = sums.max_change_m;
        patch.outline_m = outline / std::max(1e-12, sums.area_m2);
        locate(found, patch);
        cv::Mat about;
        cv::dilate(found.support, about, disc(2.0));
        const cv::Mat not_both = ~cells_with_value(window.change_m);
        const cv::Mat hidden = cells_in(window, CellState::Hidden);
        patch.hidden_m2 =
            cv::countNonZero(about & (not_both | hidden)) * map_.grid.cell_m * map_.grid.cell_m;
        noises_.push_back(noise_m3(sums, changes_.noise));
        outlines_.push_back(outline);
        by_motion_.push_back(sums.by_motion);
        changes_.patches.push_back(patch);
    }

    // Returns the number of standard deviations of an interval. Of all parts of the ground as
    // large, those were chosen that changed most, also by their errors. 95 % of them hold if each
    // gets as many standard deviations as an error exceeds with 0.05 times their share of all
    // (Benjamini and Yekutieli 2005).
    double num_sigma(double area_m2) const {
        const double num_parts = std::max(1.0, ground_m2_ / std::max(1e-12, area_m2));
        const double share = static_cast<double>(found_.size()) / num_parts;
        return exceeded_with(0.05 * std::min(1.0, share));
    }

    stats::Estimate area_of(const Found& found) const {
        const double cell_m2 = map_.grid.cell_m * map_.grid.cell_m;
        cv::Mat less;
        cv::Mat more;
        cv::erode(found.core, less, disc(0.5 * margin_cells_));
        cv::dilate(found.core, more, disc(0.5 * margin_cells_));
        return {cv::countNonZero(found.core) * cell_m2,
                cv::countNonZero(less) * cell_m2,
                cv::countNonZero(more) * cell_m2};
    }

    void locate(const Found& found, ChangePatch& patch) const {
        double num = 0.0;
        for (int row = 0; row < found.core.rows; ++row)
            for (int column = 0; column < found.core.cols; ++column)
                if (found.core.at<std::uint8_t>(row, column) != 0) {
                    const Eigen::Vector2d at =
                        map_.grid.center(row + found.window.y, column + found.window.x);
                    patch.center_m += at;
                    patch.box_m.extend(at);
                    num += 1.0;
                }
        patch.center_m /= std::max(1.0, num);
    }

    void total() {
        for (const bool grown : {true, false}) {
            ChangeTotal& total = grown ? changes_.grown : changes_.lost;
            double noise = 0.0;
            double outline = 0.0;
            Vector6d by_motion = Vector6d::Zero();
            double low = 0.0;  // chosen by their apparent change, so their errors have one sign
            for (std::size_t i = 0; i < changes_.patches.size(); ++i) {
                const ChangePatch& patch = changes_.patches[i];
                if (patch.grown != grown) continue;
                ++total.num_patches;
                total.volume_m3.value += patch.volume_m3.value;
                low += patch.volume_m3.low;
                noise = std::hypot(noise, patch.num_sigma / stats::kNormal975 * noises_[i]);
                outline += outlines_[i];
                by_motion += by_motion_[i];
                total.area_m2.value += patch.area_m2.value;
                total.area_m2.low += patch.area_m2.low;
                total.area_m2.high += patch.area_m2.high;
            }
            total.volume_m3 = interval(
                total.volume_m3.value, noise, map_.registration_sigma(by_motion) + outline);
            total.volume_m3.low = low;
            total.volume_m3.high += total.undetected_m3;
        }
    }

    ChangeMap& map_;
    const PatchOptions& options_;
    double margin_cells_;
    double ground_m2_;       // that both dives saw
    cv::Mat beyond_chance_;  // CV_8U
    std::vector<Found> found_;
    std::vector<double> noises_;
    std::vector<double> outlines_;
    std::vector<Vector6d> by_motion_;
    Changes changes_;
};

}  // namespace

Changes gather_changes(ChangeMap& map, const PatchOptions& options) {
    return Gatherer(map, options).gather();
}

}  // namespace divemesh::compare
