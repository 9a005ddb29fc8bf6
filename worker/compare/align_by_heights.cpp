#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>

#include "worker/base/angle.hpp"
#include "worker/base/parallel.hpp"
#include "worker/compare/coarse_alignment.hpp"

namespace divemesh::compare {
namespace {

constexpr int kNumHeadings = 90;
constexpr double kCellsAcross = 220.0;
constexpr double kMinCell_m = 0.04;
constexpr double kMinOverlap = 0.2;  // of the smaller surface
constexpr std::size_t kMaxCoarseAlignments = 5;
constexpr std::size_t kPerHeading = 3;
constexpr double kApart_m = 0.5;
constexpr double kApart_rad = 12.0 * base::kRadPerDeg;

// Heights of the highest vertices, 0 outside the mask; row 0 has the smallest y.
struct Heights {
    cv::Mat height;  // CV_32F, minus `level_m`
    cv::Mat mask;    // CV_32F, 1 where there is surface
    Eigen::Vector2d low = Eigen::Vector2d::Zero();
    double num = 0.0;
};

Heights heights_of(const types::Mesh& mesh, double heading, double cell_m, double level_m) {
    const Eigen::Rotation2Df rotation(static_cast<float>(heading));
    const auto flat = [&](const Eigen::Vector3f& p) -> Eigen::Vector2f {
        return rotation * Eigen::Vector2f(p.head<2>());
    };
    Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector2f high = -low;
    for (const Eigen::Vector3f& p : mesh.vertices) {
        low = low.cwiseMin(flat(p));
        high = high.cwiseMax(flat(p));
    }
    const Eigen::Vector2d size = (high - low).cast<double>() / cell_m;
    Heights result;
    result.low = low.cast<double>();
    const int rows = static_cast<int>(size.y()) + 1;
    const int columns = static_cast<int>(size.x()) + 1;
    constexpr float kNothing = std::numeric_limits<float>::lowest();
    result.height = cv::Mat(rows, columns, CV_32F, cv::Scalar::all(static_cast<double>(kNothing)));
    for (const Eigen::Vector3f& p : mesh.vertices) {
        const Eigen::Vector2d at = (flat(p).cast<double>() - result.low) / cell_m;
        float& highest = result.height.at<float>(std::min(rows - 1, static_cast<int>(at.y())),
                                                 std::min(columns - 1, static_cast<int>(at.x())));
        highest = std::max(highest, p.z() - static_cast<float>(level_m));
    }
    result.mask = cv::Mat(rows, columns, CV_32F);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            float& height = result.height.at<float>(row, column);
            const bool seen = height > kNothing;
            result.mask.at<float>(row, column) = seen ? 1.0F : 0.0F;
            if (!seen) height = 0.0F;
            result.num += seen;
        }
    return result;
}

struct Spectra {
    cv::Mat height, square, mask;
};

cv::Mat spectrum(const cv::Mat& values, const cv::Size& size) {
    cv::Mat padded = cv::Mat::zeros(size, CV_32F);
    values.copyTo(padded(cv::Rect(0, 0, values.cols, values.rows)));
    cv::dft(padded, padded, 0, values.rows);
    return padded;
}

Spectra spectra_of(const Heights& heights, const cv::Size& size) {
    return {spectrum(heights.height, size),
            spectrum(heights.height.mul(heights.height), size),
            spectrum(heights.mask, size)};
}

cv::Mat correlate(const cv::Mat& a, const cv::Mat& b) {
    cv::Mat product;
    cv::mulSpectrums(a, b, product, 0, true);
    cv::idft(product, product, cv::DFT_SCALE);
    return product;
}

struct Peak {
    double score = -1.0;
    double heading = 0.0;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
};

bool apart(const Peak& p, const Peak& q) {
    const double rotation = std::remainder(p.heading - q.heading, 2.0 * std::numbers::pi);
    return (p.shift - q.shift).head<2>().norm() > kApart_m || std::abs(rotation) > kApart_rad;
}

void keep_best(std::vector<Peak>& peaks, std::size_t num) {
    std::ranges::stable_sort(peaks, [](const Peak& p, const Peak& q) { return p.score > q.score; });
    std::vector<Peak> kept;
    for (const Peak& peak : peaks)
        if (kept.size() < num &&
            std::ranges::all_of(kept, [&](const Peak& other) { return apart(peak, other); }))
            kept.push_back(peak);
    peaks = kept;
}

// Correlates at every shift of one heading: f of a, g of the rotated b.
std::vector<Peak> peaks_at(const Heights& f,
                           const Spectra& of_f,
                           const Heights& g,
                           const cv::Size& size,
                           double heading,
                           double cell_m) {
    const Spectra of_g = spectra_of(g, size);
    const cv::Mat overlap = correlate(of_f.mask, of_g.mask);
    const cv::Mat f_sum = correlate(of_f.height, of_g.mask);
    const cv::Mat g_sum = correlate(of_f.mask, of_g.height);
    const cv::Mat f_squares = correlate(of_f.square, of_g.mask);
    const cv::Mat g_squares = correlate(of_f.mask, of_g.square);
    const cv::Mat products = correlate(of_f.height, of_g.height);
    const double min_cells = std::max(50.0, kMinOverlap * std::min(f.num, g.num));
    std::vector<Peak> peaks;
    for (int row = 0; row < size.height; ++row)
        for (int column = 0; column < size.width; ++column) {
            const auto at = [&](const cv::Mat& m) {
                return static_cast<double>(m.at<float>(row, column));
            };
            const double n = at(overlap);
            if (n < min_cells) continue;
            const double f_variance = at(f_squares) - at(f_sum) * at(f_sum) / n;
            const double g_variance = at(g_squares) - at(g_sum) * at(g_sum) / n;
            if (f_variance <= 1e-6 * n || g_variance <= 1e-6 * n) continue;  // a level plane
            const double score =
                (at(products) - at(f_sum) * at(g_sum) / n) / std::sqrt(f_variance * g_variance);
            if (score < 0.2) continue;
            const int dx = column > f.height.cols ? column - size.width : column;
            const int dy = row > f.height.rows ? row - size.height : row;
            Peak peak{score, heading, Eigen::Vector3d::Zero()};
            peak.shift.head<2>() = f.low - g.low + cell_m * Eigen::Vector2d(dx, dy);
            peak.shift.z() = (at(f_sum) - at(g_sum)) / n;
            peaks.push_back(peak);
        }
    keep_best(peaks, kPerHeading);
    return peaks;
}

double mean_height_m(const types::Mesh& mesh) {
    double sum = 0.0;
    for (const Eigen::Vector3f& p : mesh.vertices) sum += static_cast<double>(p.z());
    return sum / static_cast<double>(std::max<std::size_t>(1, mesh.vertices.size()));
}

double max_side_m(const types::Mesh& mesh) {
    Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector2f high = -low;
    for (const Eigen::Vector3f& p : mesh.vertices) {
        low = low.cwiseMin(p.head<2>());
        high = high.cwiseMax(p.head<2>());
    }
    return static_cast<double>((high - low).norm());
}

}  // namespace

std::vector<CoarseAlignment> align_by_heights(const types::Mesh& a,
                                              const types::Mesh& b,
                                              int num_threads) {
    if (a.vertices.empty() || b.vertices.empty()) return {};
    const double max_length_m = std::max(max_side_m(a), max_side_m(b));
    const double cell_m = std::max(kMinCell_m, max_length_m / kCellsAcross);
    const double level_a = mean_height_m(a);
    const double level_b = mean_height_m(b);
    const Heights f = heights_of(a, 0.0, cell_m, level_a);
    const int across_b = static_cast<int>(max_side_m(b) / cell_m) + 2;
    const cv::Size size(cv::getOptimalDFTSize(f.height.cols + across_b),
                        cv::getOptimalDFTSize(f.height.rows + across_b));
    const Spectra of_f = spectra_of(f, size);
    std::vector<std::vector<Peak>> found(kNumHeadings);
    base::for_each_index(num_threads, found.size(), [&](std::size_t i) {
        const double heading = 2.0 * std::numbers::pi * static_cast<double>(i) / kNumHeadings;
        const Heights g = heights_of(b, heading, cell_m, level_b);
        found[i] = peaks_at(f, of_f, g, size, heading, cell_m);
    });
    std::vector<Peak> peaks;
    for (const auto& some : found) peaks.insert(peaks.end(), some.begin(), some.end());
    keep_best(peaks, kMaxCoarseAlignments);
    std::vector<CoarseAlignment> coarse_alignments;
    for (const Peak& peak : peaks) {
        CoarseAlignment guess{Eigen::Isometry3d::Identity(), "geometry", peak.score};
        guess.T_a_b.linear() =
            Eigen::AngleAxisd(peak.heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        guess.T_a_b.translation() = peak.shift + Eigen::Vector3d(0, 0, level_a - level_b);
        coarse_alignments.push_back(guess);
    }
    return coarse_alignments;
}

}  // namespace divemesh::compare
