#include "worker/stereo/census_sgm.hpp"

#include <algorithm>
#include <cstdlib>
#include <opencv2/core.hpp>

#include "worker/stereo/sgm_kernels.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kRadiusX_px = 4;  // of the census window
constexpr int kRadiusY_px = 3;
constexpr int kLeftRightTolerance_px = 1;

struct Offset {
    int x;
    int y;
};

// Returns every other pixel of the 9 x 7 window, like a chess board: 30 of them, and two corners.
std::vector<Offset> census_pattern() {
    std::vector<Offset> pattern;
    for (int y = -kRadiusY_px; y <= kRadiusY_px; ++y)
        for (int x = -kRadiusX_px; x <= kRadiusX_px; ++x)
            if ((x != 0 || y != 0) && ((x + y) & 1) == 0) pattern.push_back({x, y});
    pattern.push_back({kRadiusX_px, -kRadiusY_px});
    pattern.push_back({-kRadiusX_px, kRadiusY_px});
    return pattern;
}

int whole_steps(int num_disparities) { return (num_disparities + 31) / 32 * 32; }

// Computes the census of an image, mirrored beyond its border. The planes can be read `num_behind`
// bytes past their end.
void census(const cv::Mat& image,
            CensusKernel kernel,
            bool mirrored,
            int tolerance,
            std::size_t num_behind,
            std::vector<std::uint8_t>* planes) {
    static const std::vector<Offset> kPattern = census_pattern();
    cv::Mat wide;
    cv::copyMakeBorder(
        image, wide, kRadiusY_px, kRadiusY_px, kRadiusX_px, kRadiusX_px, cv::BORDER_REFLECT_101);
    if (mirrored) cv::flip(wide, wide, 1);
    const auto at = [&](int y, Offset offset) {
        return wide.ptr<std::uint8_t>(y + kRadiusY_px + offset.y) + kRadiusX_px +
               (mirrored ? -offset.x : offset.x);
    };
    for (int p = 0; p < 4; ++p) {
        planes[p].resize(image.total() + num_behind);
        for (int y = 0; y < image.rows; ++y) {
            const std::uint8_t* neighbours[8];
            for (int k = 0; k < 8; ++k) neighbours[k] = at(y, kPattern[p * 8 + k]);
            std::uint8_t* row = planes[p].data() + static_cast<std::size_t>(y) * image.cols;
            kernel(at(y, {0, 0}), neighbours, image.cols, tolerance, row);
        }
    }
}

}  // namespace

CensusSgm::CensusSgm(int num_disparities, base::Instructions instructions)
    : num_disparities_(num_disparities),
      whole_num_disparities_(num_disparities),
      kernels_(sgm_kernels(instructions)) {}

cv::Mat CensusSgm::compute(const cv::Mat& left, const cv::Mat& right) {
    return compute(left, right, {0, whole_num_disparities_});
}

cv::Mat CensusSgm::compute(const cv::Mat& left,
                           const cv::Mat& right,
                           const types::DisparityRange& range,
                           int tolerance) {
    return compute(left, right, {{cv::Rect({}, left.size()), range}}, tolerance);
}

cv::Mat CensusSgm::compute(const cv::Mat& left,
                           const cv::Mat& right,
                           const std::vector<SearchTile>& tiles,
                           int tolerance) {
    cv::Mat disparity(left.size(), CV_32F, cv::Scalar(0.0));
    if (left.cols <= kRadiusX_px || left.rows <= kRadiusY_px) return disparity;
    image_width_ = left.cols;
    int end_disparity = 0;
    for (const SearchTile& tile : tiles)
        end_disparity =
            std::max(end_disparity, tile.range.first_px + whole_steps(tile.range.num_px));
    census(left, kernels_.census, false, tolerance, 0, left_census_);
    census(right,
           kernels_.census,
           true,
           tolerance,
           static_cast<std::size_t>(end_disparity) + kMaxVectorBytes,
           right_census_);
    winners_.create(left.size());
    for (const SearchTile& tile : tiles) find_winners(left, tile);
    right_best_.resize(static_cast<std::size_t>(image_width_) + end_disparity);
    for (int y = 0; y < left.rows; ++y) write_row(y, disparity.ptr<float>(y));
    return disparity;
}

void CensusSgm::find_winners(const cv::Mat& left, const SearchTile& tile) {
    seen_ = with_surroundings(tile.part, left.size());
    first_disparity_ = tile.range.first_px;
    num_disparities_ = whole_steps(tile.range.num_px);
    prepare();
    for (int y = seen_.y; y < seen_.br().y; y += kRowsAtOnce) {
        const int num_rows = std::min(kRowsAtOnce, seen_.br().y - y);
        for (int i = 0; i < num_rows; ++i) prepare_row(left, y + i, rows_[i]);
        aggregate(y, num_rows);
        select_winners(num_rows);
        for (int i = 0; i < num_rows; ++i) keep_winners(rows_[i], y + i, tile.part);
    }
}

void CensusSgm::Winners::create(cv::Size size) {
    for (cv::Mat* bytes : {&min_cost, &is_unique, &lower, &upper}) bytes->create(size, CV_8U);
    min_at.create(size, CV_16S);
}

void CensusSgm::Costs::resize(std::size_t num_bytes) {
    lines.resize((num_bytes + kMaxVectorBytes - 1) / kMaxVectorBytes);
}

// Sets a path's costs to 0 before its first pixel, so that this pixel gets its own costs.
void CensusSgm::begin_path(std::uint8_t* costs) const {
    std::fill_n(costs, num_disparities_, std::uint8_t{0});
    std::fill(costs + num_disparities_, costs + stride_, std::uint8_t{kOutsideCost});
}

void CensusSgm::prepare() {
    width_ = seen_.width;
    stride_ = (num_disparities_ + kernels_.vector_bytes - 1) / kernels_.vector_bytes *
              kernels_.vector_bytes;
    const auto width = static_cast<std::size_t>(width_);
    for (Row& row : rows_) {
        row.cost.resize(width * stride_);
        row.sum.resize(width * stride_);
        row.min_cost.resize(width);
        row.min_at.resize(width);
        row.is_unique.resize(width);
        row.lower.resize(width);
        row.upper.resize(width);
        for (auto& penalty : row.penalty) penalty.resize(width);
    }
    for (Slots& path : above_) {
        path.costs.resize((width + 1) * stride_);
        for (int slot = 0; slot <= width_; ++slot)
            begin_path(path.costs.begin() + static_cast<std::ptrdiff_t>(slot) * stride_);
        path.min_cost.assign(width + 1, 0);
    }
}

void CensusSgm::prepare_row(const cv::Mat& left, int y, Row& row) const {
    const std::uint8_t* grey = left.ptr<std::uint8_t>(y) + seen_.x;
    const std::uint8_t* above = left.ptr<std::uint8_t>(std::max(0, y - 1)) + seen_.x;
    const PenaltyKernel penalties = kernels_.penalties;
    // A path's first pixel has no predecessor: any penalty is fine.
    penalties(grey + 1, above, width_ - 1, row.penalty[0].data() + 1);
    penalties(grey, above, width_, row.penalty[1].data());
    penalties(grey, above + 1, width_ - 1, row.penalty[2].data());
    penalties(grey + 1, grey, width_ - 1, row.penalty[3].data() + 1);
    std::copy(row.penalty[3].begin() + 1, row.penalty[3].end(), row.penalty[4].begin());
}

void CensusSgm::aggregate(int y, int num_rows) {
    ForwardRow forward[kRowsAtOnce];
    for (int i = 0; i < num_rows; ++i) {
        Row& row = rows_[i];
        forward[i].width = width_;
        forward[i].first_x = seen_.x;
        forward[i].first_disparity = first_disparity_;
        forward[i].num_disparities = num_disparities_;
        for (int p = 0; p < 4; ++p) {
            const std::ptrdiff_t row_start = static_cast<std::ptrdiff_t>(y + i) * image_width_;
            forward[i].left[p] = left_census_[p].data() + row_start + seen_.x;
            forward[i].right_reversed[p] = right_census_[p].data() + row_start + image_width_ -
                                           seen_.br().x + first_disparity_;
            forward[i].penalty[p] = row.penalty[p].data();
        }
        for (int p = 0; p < 3; ++p) forward[i].above[p] = vertical_path(p, y + i - seen_.y);
        forward[i].cost = row.cost.begin();
        forward[i].sum = row.sum.begin();
    }
    kernels_.forward(forward, num_rows);
}

VerticalPath CensusSgm::vertical_path(int p, int y) {
    const int num_slots = width_ + 1;
    const int sideways = p - 1;  // -1: from above left, 0: above, 1: above right
    VerticalPath path;
    path.costs = above_[p].costs.begin();
    path.min_cost = above_[p].min_cost.data();
    path.first_slot = (sideways * y % num_slots + num_slots) % num_slots;
    if (sideways != 0) {  // a diagonal path starts again where it enters the image
        const int slot =
            sideways < 0 ? path.first_slot : (path.first_slot + width_ - 1) % num_slots;
        begin_path(path.costs + static_cast<std::ptrdiff_t>(slot) * stride_);
        path.min_cost[slot] = 0;
    }
    return path;
}

void CensusSgm::select_winners(int num_rows) {
    BackwardRow backward[kRowsAtOnce];
    for (int i = 0; i < num_rows; ++i) {
        Row& row = rows_[i];
        backward[i].width = width_;
        backward[i].num_disparities = num_disparities_;
        backward[i].penalty = row.penalty[4].data();
        backward[i].cost = row.cost.begin();
        backward[i].sum = row.sum.begin();
        backward[i].min_cost = row.min_cost.data();
        backward[i].min_at = row.min_at.data();
        backward[i].is_unique = row.is_unique.data();
        backward[i].lower = row.lower.data();
        backward[i].upper = row.upper.data();
    }
    kernels_.backward(backward, num_rows);
}

// Keeps the winners of the tile itself.
void CensusSgm::keep_winners(const Row& row, int y, const cv::Rect& part) {
    if (y < part.y || y >= part.br().y) return;
    const int begin = part.x - seen_.x;
    const auto keep = [&](const std::vector<std::uint8_t>& bytes, cv::Mat& image) {
        std::copy_n(bytes.begin() + begin, part.width, image.ptr<std::uint8_t>(y) + part.x);
    };
    keep(row.min_cost, winners_.min_cost);
    keep(row.is_unique, winners_.is_unique);
    keep(row.lower, winners_.lower);
    keep(row.upper, winners_.upper);
    std::transform(row.min_at.begin() + begin,
                   row.min_at.begin() + begin + part.width,
                   winners_.min_at.ptr<std::int16_t>(y) + part.x,
                   [&](std::int16_t d) { return static_cast<std::int16_t>(d + first_disparity_); });
}

// Left-right check: of the pixels that map to one pixel of the right image the cheapest is
// confirmed, of equal ones the rightmost. Cost and disparity are packed into one number, with the
// larger disparity lower. Matches left of the image are stored before the others.
void CensusSgm::write_row(int y, float* disparity_px) {
    constexpr std::uint32_t kMaxPacked = 0xffff;
    const std::uint8_t* min_cost = winners_.min_cost.ptr<std::uint8_t>(y);
    const std::int16_t* min_at = winners_.min_at.ptr<std::int16_t>(y);
    std::uint8_t* is_unique = winners_.is_unique.ptr<std::uint8_t>(y);
    std::fill(right_best_.begin(), right_best_.end(), ~std::uint32_t{0});
    std::uint32_t* best = right_best_.data() + right_best_.size() - image_width_;  // by x - d
    for (int x = 0; x < image_width_; ++x) {
        const int d = min_at[x];
        const std::uint32_t found = (std::uint32_t{min_cost[x]} << 16) | (kMaxPacked - d);
        best[x - d] = std::min(best[x - d], found);
    }
    for (int x = 0; x < image_width_; ++x) {
        const int d = min_at[x];
        const int other = static_cast<int>(kMaxPacked - (best[x - d] & kMaxPacked));
        if (std::abs(other - d) > kLeftRightTolerance_px) is_unique[x] = 0;
    }
    WinnerRow winners;
    winners.width = image_width_;
    winners.min_cost = min_cost;
    winners.min_at = min_at;
    winners.lower = winners_.lower.ptr<std::uint8_t>(y);
    winners.upper = winners_.upper.ptr<std::uint8_t>(y);
    winners.is_confirmed = is_unique;
    kernels_.place(winners, disparity_px);
}

}  // namespace divemesh::stereo
