// Measures where the mosaic of a simulated dive shows things: blocks of mosaic.tif are found again
// in the orthographic view of the scene's own colours, cast at the same pixels.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/mosaic_files.hpp"
#include "worker/io/raster_reader.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/simulator/ray_caster.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/surface_color.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kBlock_px = 48;
constexpr int kReach_px = 12;         // how far a block is searched
constexpr int kMaxBlocks = 2000;      // spread over the mosaic
constexpr double kBlur_px = 8.0;      // what is smoother is light, not texture
constexpr double kMinLikeness = 0.6;  // normalised cross-correlation
constexpr double kMaxSecond = 0.8;    // likeness of another place, of the best one's

// The colours of a place seen from above, along the vertical of a model's world.
class TrueView {
public:
    TrueView(const simulator::Scene& scene,
             std::uint64_t seed,
             const Eigen::Isometry3d& T_scene_world)
        : scene_(scene),
          caster_(scene.vertices, scene.triangles),
          noise_(simulator::texture_noise(seed)),
          T_scene_world_(T_scene_world) {}

    // Returns the green of a rectangle of pixels, CV_32F; -1 where nothing lies below.
    cv::Mat green(const types::RasterGrid& grid, const cv::Rect& pixels) const {
        cv::Mat seen(pixels.size(), CV_32F, cv::Scalar(-1.0));
        for (int row = 0; row < pixels.height; ++row)
            for (int column = 0; column < pixels.width; ++column) {
                const Eigen::Vector3d above(
                    grid.corner_x_m + grid.pixel_m * (pixels.x + column + 0.5),
                    grid.corner_y_m - grid.pixel_m * (pixels.y + row + 0.5),
                    kAbove_m);
                const Eigen::Vector3f origin = (T_scene_world_ * above).cast<float>();
                const Eigen::Vector3f down =
                    (T_scene_world_.linear() * -Eigen::Vector3d::UnitZ()).cast<float>();
                const simulator::RayHit hit = caster_.cast(origin, down);
                if (hit.valid())
                    seen.at<float>(row, column) =
                        green_at(hit, origin + hit.t * down, static_cast<float>(grid.pixel_m));
            }
        return seen;
    }

private:
    static constexpr double kAbove_m = 20.0;

    float green_at(const simulator::RayHit& hit, const Eigen::Vector3f& p, float pixel_m) const {
        const auto& corners = scene_.triangles[hit.triangle];
        const Eigen::Vector3f normal = (1.0F - hit.u - hit.v) * scene_.normals[corners[0]] +
                                       hit.u * scene_.normals[corners[1]] +
                                       hit.v * scene_.normals[corners[2]];
        return simulator::surface_color(scene_.objects[scene_.triangle_object[hit.triangle]],
                                        noise_,
                                        p,
                                        normal.normalized(),
                                        pixel_m)
            .y();
    }

    const simulator::Scene& scene_;
    simulator::RayCaster caster_;
    simulator::NoiseField noise_;
    Eigen::Isometry3d T_scene_world_;
};

cv::Mat without_light(const cv::Mat& image) {
    cv::Mat light;
    cv::GaussianBlur(image, light, {}, kBlur_px);
    return image - light;
}

// Returns the offset of a parabola's peak through three values, in their spacing.
double peak_offset(float before, float peak, float after) {
    const double bend = before - 2.0 * peak + after;
    return bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
}

// Returns where the mosaic shows what the truth has at a place, from that place, px; nullopt if it
// is not found, at the edge of the search, or in two places.
std::optional<cv::Point2d> displacement_px(const cv::Mat& block, const cv::Mat& truth) {
    cv::Mat likeness;
    cv::matchTemplate(without_light(truth), without_light(block), likeness, cv::TM_CCOEFF_NORMED);
    double best = 0.0;
    cv::Point at;
    cv::minMaxLoc(likeness, nullptr, &best, nullptr, &at);
    if (best < kMinLikeness || at.x < 1 || at.y < 1 || at.x + 1 >= likeness.cols ||
        at.y + 1 >= likeness.rows)
        return std::nullopt;
    const auto row = [&](int dy) { return likeness.ptr<float>(at.y + dy) + at.x; };
    const cv::Point2d found(at.x + peak_offset(row(0)[-1], row(0)[0], row(0)[1]),
                            at.y + peak_offset(row(-1)[0], row(0)[0], row(1)[0]));
    cv::Mat others = likeness.clone();
    cv::circle(others, at, 4, cv::Scalar(-1.0), cv::FILLED);
    double second = 0.0;
    cv::minMaxLoc(others, nullptr, &second);
    if (second > kMaxSecond * best) return std::nullopt;
    return cv::Point2d(kReach_px, kReach_px) - found;
}

// Returns the corners of blocks that are all surface, at most kMaxBlocks.
std::vector<cv::Rect> blocks_of(const cv::Mat& alpha) {
    std::vector<cv::Rect> blocks;
    for (int y = kReach_px; y + kBlock_px + kReach_px <= alpha.rows; y += kBlock_px)
        for (int x = kReach_px; x + kBlock_px + kReach_px <= alpha.cols; x += kBlock_px) {
            const cv::Rect block(x, y, kBlock_px, kBlock_px);
            if (cv::countNonZero(alpha(block)) == block.area()) blocks.push_back(block);
        }
    std::vector<cv::Rect> spread;
    const std::size_t step = blocks.size() / kMaxBlocks + 1;
    for (std::size_t i = 0; i < blocks.size(); i += step) spread.push_back(blocks[i]);
    return spread;
}

nlohmann::json judge(const std::vector<std::optional<cv::Point2d>>& found, double pixel_m) {
    std::vector<double> lengths_m;
    cv::Point2d sum;
    for (const auto& displacement : found) {
        if (!displacement) continue;
        lengths_m.push_back(pixel_m * std::hypot(displacement->x, displacement->y));
        sum += *displacement;
    }
    nlohmann::json judged = {
        {"num_blocks", found.size()}, {"num_found", lengths_m.size()}, {"pixel_m", pixel_m}};
    if (lengths_m.empty()) return judged;
    std::sort(lengths_m.begin(), lengths_m.end());
    const auto quantile = [&](double share) {
        return lengths_m[static_cast<std::size_t>(share *
                                                  static_cast<double>(lengths_m.size() - 1))];
    };
    const auto num = static_cast<double>(lengths_m.size());
    judged["median_m"] = quantile(0.5);
    judged["p95_m"] = quantile(0.95);
    judged["mean_east_m"] = pixel_m * sum.x / num;
    judged["mean_north_m"] = -pixel_m * sum.y / num;
    return judged;
}

int run(int argc, char** argv) {
    CLI::App app("Measures the displacement of the mosaic of a simulated dive.");
    fs::path model;
    fs::path dive;
    std::string scene_name = "barge";
    std::uint64_t seed = 1;
    double length_m = 6.0;
    int year = 1;
    app.add_option("model", model, "reconstruction")->required();
    app.add_option("dive", dive, "what it was made from, by `divemesh simulate`")->required();
    app.add_option("--scene", scene_name, "as given to simulate");
    app.add_option("--seed", seed, "as given to simulate");
    app.add_option("--length-m", length_m, "as given to simulate");
    app.add_option("--year", year, "as given to simulate");
    CLI11_PARSE(app, argc, argv);

    const fs::path truth = dive / "mav0/state_groundtruth_estimate0/data.csv";
    const Eigen::Isometry3d T_scene_world =
        evaluation::trajectory_error(io::read_trajectory(model / "trajectory.tum").poses,
                                     io::read_trajectory(truth).poses)
            .T_reference_surface;
    const fs::path description = model / "mosaic.json";
    const types::RasterGrid grid =
        io::mosaic_grid_of(nlohmann::json::parse(std::ifstream(description)), description);
    io::RasterReader reader(model / "mosaic.tif");
    const cv::Mat mosaic = reader.rows(0, reader.size().height);
    cv::Mat green;
    cv::Mat alpha;
    cv::extractChannel(mosaic, green, 1);
    cv::extractChannel(mosaic, alpha, 3);
    green.convertTo(green, CV_32F, 1.0 / 255.0);

    const simulator::Scene scene =
        simulator::make_scene(simulator::scene_kind_from_string(scene_name), seed, year, length_m);
    const TrueView view(scene, seed, T_scene_world);
    const std::vector<cv::Rect> blocks = blocks_of(alpha);
    std::vector<std::optional<cv::Point2d>> found(blocks.size());
    base::for_each_index(0, blocks.size(), [&](std::size_t i) {
        cv::Rect around = blocks[i];
        around -= cv::Point(kReach_px, kReach_px);
        around += cv::Size(2 * kReach_px, 2 * kReach_px);
        const cv::Mat seen = view.green(grid, around);
        if (cv::countNonZero(seen < 0.0F) == 0) found[i] = displacement_px(green(blocks[i]), seen);
    });
    std::printf("%s\n", judge(found, grid.pixel_m).dump(2).c_str());
    return 0;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) try {
    return divemesh::bench::run(argc, argv);
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
