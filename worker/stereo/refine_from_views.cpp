#include "worker/stereo/refine_from_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "worker/base/lanes.hpp"
#include "worker/types/disparity_range.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kReach = 2;  // of the window, in samples
constexpr int kNumSamples = (2 * kReach + 1) * (2 * kReach + 1);
constexpr int kNumSteps = 3;       // of Gauss-Newton
constexpr int kSlopeReach_px = 4;  // of the disparity's slope
constexpr float kMaxSlope = 0.5F;
constexpr float kMinCorrelation = 0.8F;
constexpr float kMinDeviation = 2.0F;  // of grey values in a window
constexpr float kMinDepth = 0.01F;     // in a neighbour, of the depth here
// In a neighbour, of what all pixels around share: poses, lenses, slant, interpolation.
constexpr float kSharedError_px = 0.3F;
constexpr float kMaxStep_px = 1.0F;
constexpr float kAgreement_sigmas = 3.0F;

// The samples of a window are `stride_px` apart. Pixels on a grid are measured, those between take
// what the grid says.
struct Grid {
    int step_px;
    int stride_px;

    int margin_px() const { return std::max(kReach * stride_px, kSlopeReach_px); }
};
Grid grid_for(int width_px, Density density) {
    const bool is_large = width_px > types::kLargeWidth_px;
    const int stride_px = is_large ? 3 : 2;
    if (density == Density::EveryPixel) return {is_large ? 2 : 1, stride_px};
    return {is_large ? 4 : 2, stride_px};
}

// An image that gives the four pixels around a place at once.
class PackedImage {
public:
    explicit PackedImage(const cv::Mat& image)
        : width_(image.cols - 1), height_(image.rows - 1), fours_(pixel(0, height_)) {
        for (int y = 0; y < height_; ++y) {
            const auto* above = image.ptr<std::uint8_t>(y);
            const auto* below = image.ptr<std::uint8_t>(y + 1);
            for (int x = 0; x < width_; ++x)
                fours_[pixel(x, y)] = static_cast<std::uint32_t>(above[x]) |
                                      static_cast<std::uint32_t>(above[x + 1]) << 8 |
                                      static_cast<std::uint32_t>(below[x]) << 16 |
                                      static_cast<std::uint32_t>(below[x + 1]) << 24;
        }
    }

    // One more pixel than these has a neighbour to its right and below.
    int width() const { return width_; }
    int height() const { return height_; }
    const std::uint32_t* data() const { return fours_.data(); }

private:
    std::size_t pixel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }

    int width_;
    int height_;
    std::vector<std::uint32_t> fours_;
};

struct View {
    View(const types::RectifiedRig& rig, const NeighbourView& neighbour)
        : image(neighbour.left), projection(rig, neighbour.T_other_cam) {}

    PackedImage image;
    ViewProjection projection;
};

// Eight pixels of the grid: the windows around them without their means, and the planes that they
// are taken to lie in.
struct Windows {
    base::Floats values[kNumSamples];
    base::Floats mean;
    base::Floats squares;  // sum of the squared values
    base::Floats slope_u;
    base::Floats slope_v;
    float u_px;  // of the first one
    float v_px;
    Grid grid;
};

// What the neighbours say of eight disparities: sums over views and samples.
struct NormalEquations {
    base::Floats information = {};
    base::Floats gradient = {};
    base::Floats residual = {};
    base::Floats shift_squared = {};  // px of a neighbour per px of disparity
    base::Floats num_views = {};
};

struct Point {
    base::Floats x, y, z;
};

// The sums over the samples of a window that alignment needs.
struct Sums {
    base::Floats value = {}, slide = {}, value_value = {}, value_window = {}, slide_window = {},
                 slide_slide = {}, slide_value = {};
};

// Adds one sample of each window, at (x, y) in the view, where it is seen. `inverse` is 1 / z
// there.
DIVEMESH_INLINE_BODY void add_sample(const View& view,
                                     const Windows& windows,
                                     int sample,
                                     base::Floats inverse,
                                     base::Floats x,
                                     base::Floats y,
                                     base::Masks seen,
                                     Sums& sums) {
    const Eigen::Vector3f& m = view.projection.m;
    const base::Masks left = seen & base::to_integers(x);
    const base::Masks top = seen & base::to_integers(y);
    const base::Masks index = top * view.image.width() + left;
    base::Masks fours;
    for (int i = 0; i < base::kLanes; ++i)
        fours[i] = static_cast<std::int32_t>(view.image.data()[index[i]]);
    const auto part = [&](int shift) {
        return __builtin_convertvector((fours >> shift) & 0xff, base::Floats);
    };
    const base::Floats p = x - __builtin_convertvector(left, base::Floats);
    const base::Floats q = y - __builtin_convertvector(top, base::Floats);
    const base::Floats a = part(0), b = part(8), c = part(16), d = part(24);
    const base::Floats upper = a + p * (b - a), lower = c + p * (d - c);
    const base::Floats value = upper + q * (lower - upper) - windows.mean;
    const base::Floats along_u = (b - a) + q * ((d - c) - (b - a));
    const base::Floats slide =
        (along_u * (m.x() - x * m.z()) + (lower - upper) * (m.y() - y * m.z())) * inverse;
    const base::Floats window = windows.values[sample];
    sums.value += value;
    sums.slide += slide;
    sums.value_value += value * value;
    sums.value_window += value * window;
    sums.slide_window += slide * window;
    sums.slide_slide += slide * slide;
    sums.slide_value += slide * value;
}

// Adds what one view says, where it shows the windows.
DIVEMESH_INLINE_BODY void add_view(const View& view,
                                   const Windows& windows,
                                   base::Floats disparity_px,
                                   NormalEquations& normal) {
    const Eigen::Matrix3f& M = view.projection.M;
    const Eigen::Vector3f& m = view.projection.m;
    const base::Floats u =
        windows.u_px + __builtin_convertvector(base::kLaneNumbers, base::Floats) *
                           static_cast<float>(windows.grid.step_px);
    const auto row = [&](int i) {
        return M(i, 0) * u + (M(i, 1) * windows.v_px + M(i, 2)) + m[i] * disparity_px;
    };
    const Point from{row(0), row(1), row(2)};
    const Point step_u{M(0, 0) + m[0] * windows.slope_u,
                       M(1, 0) + m[1] * windows.slope_u,
                       M(2, 0) + m[2] * windows.slope_u};
    const Point step_v{M(0, 1) + m[0] * windows.slope_v,
                       M(1, 1) + m[1] * windows.slope_v,
                       M(2, 1) + m[2] * windows.slope_v};
    const auto width = static_cast<float>(view.image.width());
    const auto height = static_cast<float>(view.image.height());
    base::Masks seen = from.z > kMinDepth;
    Sums sums;
    int sample = 0;
    for (int j = -kReach; j <= kReach; ++j)
        for (int i = -kReach; i <= kReach; ++i, ++sample) {
            const auto du = static_cast<float>(i * windows.grid.stride_px);
            const auto dv = static_cast<float>(j * windows.grid.stride_px);
            const Point at{from.x + step_u.x * du + step_v.x * dv,
                           from.y + step_u.y * du + step_v.y * dv,
                           from.z + step_u.z * du + step_v.z * dv};
            const base::Floats inverse = 1.0F / at.z;
            const base::Floats x = at.x * inverse, y = at.y * inverse;
            seen &= (at.z > kMinDepth) & (x >= 0.0F) & (y >= 0.0F) & (x < width) & (y < height);
            if (!base::any(seen)) return;
            add_sample(view, windows, sample, inverse, x, y, seen, sums);
        }
    constexpr auto kCount = static_cast<float>(kNumSamples);
    const base::Floats squares = sums.value_value - sums.value * sums.value / kCount;
    const base::Floats product = sums.value_window;
    seen &= product > kMinCorrelation *
                          base::square_root(base::max(squares, base::Floats{}) * windows.squares);
    // Gain and bias of the window follow the view; what they explain of a change of the disparity
    // says nothing about it.
    const base::Floats gain = product / windows.squares;
    const base::Floats weight = 1.0F / (gain * gain);
    const base::Floats information = sums.slide_slide - sums.slide * sums.slide / kCount -
                                     sums.slide_window * sums.slide_window / windows.squares;
    const base::Floats gradient =
        sums.slide_value - sums.slide * sums.value / kCount - gain * sums.slide_window;
    const base::Floats inverse = 1.0F / from.z;
    const base::Floats shift_u = (m.x() - from.x * inverse * m.z()) * inverse;
    const base::Floats shift_v = (m.y() - from.y * inverse * m.z()) * inverse;
    normal.information += base::select(seen, weight * information);
    normal.gradient += base::select(seen, weight * gradient);
    normal.residual += base::select(seen, weight * (squares - gain * product));
    normal.shift_squared += base::select(seen, shift_u * shift_u + shift_v * shift_v);
    normal.num_views += base::select(seen, base::broadcast(1.0F));
}

// Aligns eight windows with the views. Sets `variance_px2` to 0 where that fails.
DIVEMESH_INLINE_BODY void align(const View* views,
                                std::size_t num_views,
                                const Windows& windows,
                                base::Floats& disparity_px,
                                base::Floats& variance_px2) {
    for (int step = 0; step < kNumSteps; ++step) {
        NormalEquations normal;
        for (std::size_t view = 0; view < num_views; ++view)
            add_view(views[view], windows, disparity_px, normal);
        const base::Masks good =
            (normal.num_views >= 2.0F) & (normal.information > 0.0F) & (windows.squares > 0.0F);
        variance_px2 = base::select(good, base::broadcast(1.0F));
        if (!base::any(good)) return;
        const base::Floats change_px = base::min(
            base::broadcast(kMaxStep_px),
            base::max(base::broadcast(-kMaxStep_px), -normal.gradient / normal.information));
        disparity_px += base::select(good, change_px);
        constexpr auto kFree = static_cast<float>(kNumSamples - 3);
        const base::Floats noise =
            base::max(normal.residual, base::Floats{}) / (normal.num_views * kFree);
        variance_px2 = base::select(
            good,
            noise / normal.information + kSharedError_px * kSharedError_px / normal.shift_squared);
    }
}

using Align = void (*)(const View*, std::size_t, const Windows&, base::Floats&, base::Floats&);

class Refiner {
public:
    Refiner(const types::RectifiedRig& rig,
            const cv::Mat& left,
            std::span<const NeighbourView> neighbours,
            const Grid& grid,
            base::Instructions instructions)
        : grid_(grid), left_(left), align_(base::compiled_for<align>(instructions)) {
        for (const NeighbourView& neighbour : neighbours) views_.emplace_back(rig, neighbour);
    }

    int refine(types::DepthMap& depth) {
        measure(depth.disparity_px);
        return average(depth);
    }

private:
    // What the neighbours say of one pixel of the grid.
    struct Node {
        float disparity_px = 0.0F;
        float variance_px2 = 0.0F;  // 0: nothing
        float slope_u = 0.0F;
        float slope_v = 0.0F;
    };

    void measure(const cv::Mat& disparity_px) {
        const int margin = grid_.margin_px();
        columns_ = (left_.cols - 2 * margin + grid_.step_px - 1) / grid_.step_px;
        rows_ = (left_.rows - 2 * margin + grid_.step_px - 1) / grid_.step_px;
        nodes_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), {});
        for (int row = 0; row < rows_; ++row)
            for (int column = 0; column < columns_; column += base::kLanes)
                measure_eight(disparity_px, column, row);
    }

    Node& node(int column, int row) {
        return nodes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                      static_cast<std::size_t>(column)];
    }

    void measure_eight(const cv::Mat& disparity_px, int column, int row) {
        const int margin = grid_.margin_px();
        const int v = margin + row * grid_.step_px;
        Windows windows{};
        windows.grid = grid_;
        windows.u_px = static_cast<float>(margin + column * grid_.step_px);
        windows.v_px = static_cast<float>(v);
        base::Floats disparities = {};
        const int count = std::min(base::kLanes, columns_ - column);
        for (int i = 0; i < count; ++i) {
            const int u = margin + (column + i) * grid_.step_px;
            const float stated_px = disparity_px.at<float>(v, u);
            if (stated_px <= 0.0F) continue;
            disparities[i] = stated_px;
            windows.slope_u[i] = slope(disparity_px, u, v, kSlopeReach_px, 0);
            windows.slope_v[i] = slope(disparity_px, u, v, 0, kSlopeReach_px);
            read_window(u, v, i, windows);
        }
        if (!base::any(windows.squares > 0.0F)) return;
        base::Floats variances = {};
        align_(views_.data(), views_.size(), windows, disparities, variances);
        for (int i = 0; i < count; ++i)
            if (variances[i] > 0.0F)
                node(column + i, row) = {
                    disparities[i], variances[i], windows.slope_u[i], windows.slope_v[i]};
    }

    // Reads the window around a pixel into a lane; leaves `squares` 0 if it has no texture.
    void read_window(int u, int v, int lane, Windows& windows) const {
        const int stride = grid_.stride_px;
        float sum = 0.0F;
        int sample = 0;
        for (int j = -kReach; j <= kReach; ++j)
            for (int i = -kReach; i <= kReach; ++i, ++sample) {
                const float value = left_.at<std::uint8_t>(v + j * stride, u + i * stride);
                windows.values[sample][lane] = value;
                sum += value;
            }
        const float mean = sum / kNumSamples;
        float squares = 0.0F;
        for (base::Floats& values : windows.values) {
            values[lane] -= mean;
            squares += values[lane] * values[lane];
        }
        windows.mean[lane] = mean;
        windows.squares[lane] =
            squares >= kNumSamples * kMinDeviation * kMinDeviation ? squares : 0.0F;
    }

    // Returns the slope of the disparity along an axis, where both sides are known and near.
    static float slope(const cv::Mat& disparity_px, int u, int v, int du, int dv) {
        const float ahead = disparity_px.at<float>(v + dv, u + du);
        const float behind = disparity_px.at<float>(v - dv, u - du);
        if (ahead <= 0.0F || behind <= 0.0F) return 0.0F;
        const float slope = (ahead - behind) / static_cast<float>(2 * kSlopeReach_px);
        return std::abs(slope) < kMaxSlope ? slope : 0.0F;
    }

    // Averages each disparity with what the grid says of it. Returns how many changed.
    int average(types::DepthMap& depth) {
        int num_changed = 0;
        const int margin = grid_.margin_px();
        for (int v = margin; v < margin + (rows_ - 1) * grid_.step_px; ++v) {
            auto* disparities = depth.disparity_px.ptr<float>(v);
            auto* sigmas = depth.sigma_disparity_px.ptr<float>(v);
            for (int u = margin; u < margin + (columns_ - 1) * grid_.step_px; ++u)
                if (disparities[u] > 0.0F && average(u, v, disparities[u], sigmas[u]))
                    ++num_changed;
        }
        return num_changed;
    }

    bool average(int u, int v, float& disparity_px, float& sigma_px) {
        const float stated_variance = sigma_px * sigma_px;
        const int column = (u - grid_.margin_px()) / grid_.step_px;
        const int row = (v - grid_.margin_px()) / grid_.step_px;
        float weights = 0.0F, sum_px = 0.0F, sum_variance = 0.0F;
        for (const int down : {0, 1})
            for (const int across : {0, 1}) {
                const Node& near = node(column + across, row + down);
                if (near.variance_px2 <= 0.0F) continue;
                const int du = u - grid_.margin_px() - (column + across) * grid_.step_px;
                const int dv = v - grid_.margin_px() - (row + down) * grid_.step_px;
                const float found_px = near.disparity_px + near.slope_u * static_cast<float>(du) +
                                       near.slope_v * static_cast<float>(dv);
                const float difference_px = found_px - disparity_px;
                if (difference_px * difference_px >
                    kAgreement_sigmas * kAgreement_sigmas * (near.variance_px2 + stated_variance))
                    continue;
                const float weight = static_cast<float>((grid_.step_px - std::abs(du)) *
                                                        (grid_.step_px - std::abs(dv)));
                weights += weight;
                sum_px += weight * found_px;
                sum_variance += weight * near.variance_px2;
            }
        if (weights <= 0.0F) return false;
        const float variance = sum_variance / weights;
        const float share = stated_variance / (variance + stated_variance);
        disparity_px += share * (sum_px / weights - disparity_px);
        sigma_px = std::sqrt(share * variance);
        return true;
    }

    Grid grid_;
    cv::Mat left_;
    Align align_;
    std::vector<View> views_;
    int columns_ = 0;
    int rows_ = 0;
    std::vector<Node> nodes_;
};

}  // namespace

int refine_from_views(const types::RectifiedRig& rig,
                      const cv::Mat& left,
                      std::span<const NeighbourView> neighbours,
                      Density density,
                      types::DepthMap& depth,
                      base::Instructions instructions) {
    const Grid grid = grid_for(left.cols, density);
    if (neighbours.size() < 2 || depth.disparity_px.empty() ||
        std::min(left.cols, left.rows) <= 2 * grid.margin_px())
        return 0;
    return Refiner(rig, left, neighbours, grid, instructions).refine(depth);
}

}  // namespace divemesh::stereo
