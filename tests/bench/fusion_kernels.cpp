// Steps 7 and 8 on one thread: keyframes of 640x480 pixels over a rough bed, each 8 cm on, into
// voxels of a centimetre with colour and into the octree of points half as fine. Reading them is
// not in it.
#include <benchmark/benchmark.h>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/bench/measured.hpp"
#include "tests/synthetic/ideal_rig.hpp"
#include "worker/fusion/octree_volume.hpp"
#include "worker/fusion/tsdf_volume.hpp"
#include "worker/mesh/marching_cubes.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::bench {
namespace {

constexpr int kNumKeyframes = 16;
constexpr double kVoxel_m = 0.01;

types::RectifiedRig vga_rig() { return synthetic::ideal_rig(640, 480, 498.0); }

struct DeepKeyframe {
    types::Keyframe keyframe;
    types::KeyframeImages images;
};

// Depth of the bed under a pixel of a camera at x_m that looks down from 1.6 m.
double depth_of_bed(const Eigen::Vector3d& ray, double x_m) {
    double depth = 1.6;
    for (int round = 0; round < 8; ++round) {
        const double x = x_m + depth * ray.x();
        const double y = depth * ray.y();
        depth = 1.6 - 0.15 * std::sin(3.0 * x) * std::cos(4.0 * y) - 0.03 * std::sin(17.0 * x + y);
    }
    return depth;
}

DeepKeyframe keyframe_at(double x_m, cv::RNG& random) {
    const types::RectifiedRig rig = vga_rig();
    DeepKeyframe made;
    made.keyframe.T_world_cam.translation() = Eigen::Vector3d(x_m, 0.0, 0.0);
    made.images.left_color = cv::Mat(rig.height_px, rig.width_px, CV_8UC3);
    random.fill(made.images.left_color, cv::RNG::UNIFORM, 0, 255);
    cv::Mat disparity(rig.height_px, rig.width_px, CV_32F);
    random.fill(disparity, cv::RNG::NORMAL, 0.0, 0.5);
    cv::GaussianBlur(disparity, disparity, {7, 7}, 1.5);
    for (int v = 0; v < rig.height_px; ++v)
        for (int u = 0; u < rig.width_px; ++u)
            disparity.at<float>(v, u) +=
                static_cast<float>(rig.disparity_px(depth_of_bed(rig.point_cam(u, v, 1.0), x_m)));
    made.images.depth = {disparity, cv::Mat(rig.height_px, rig.width_px, CV_32F, cv::Scalar(0.15))};
    return made;
}

const std::vector<DeepKeyframe>& keyframes() {
    static const std::vector<DeepKeyframe> all = [] {
        cv::RNG random(1);
        std::vector<DeepKeyframe> made;
        for (int i = 0; i < kNumKeyframes; ++i) made.push_back(keyframe_at(0.08 * i, random));
        return made;
    }();
    return all;
}

template <typename MadeVolume>
void fuse(benchmark::State& state, double voxel_m) {
    fusion::VolumeSettings settings;
    settings.rig = vga_rig();
    settings.voxel_m = voxel_m;
    settings.num_threads = 1;
    keyframes();
    std::int64_t memory_bytes = 0;
    for ([[maybe_unused]] auto _ : state) {
        MadeVolume volume(settings);
        for (const DeepKeyframe& frame : keyframes())
            volume.add(frame.keyframe,
                       fusion::DepthView(
                           settings.rig,
                           frame.images,
                           fusion::choose_sampling(settings.rig, frame.images.depth, kVoxel_m)));
        memory_bytes = volume.memory_bytes();
    }
    state.counters["per_keyframe"] = benchmark::Counter(
        kNumKeyframes, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["MB"] = 1e-6 * static_cast<double>(memory_bytes);
}

void tsdf_fusion(benchmark::State& state) { fuse<fusion::TsdfVolume>(state, kVoxel_m); }
BENCHMARK(tsdf_fusion)->Unit(benchmark::kMillisecond);

void octree_fusion(benchmark::State& state) { fuse<fusion::OctreeVolume>(state, 0.5 * kVoxel_m); }
BENCHMARK(octree_fusion)->Unit(benchmark::kMillisecond);

void depth_view(benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state)
        for (const DeepKeyframe& frame : keyframes())
            benchmark::DoNotOptimize(
                fusion::DepthView(
                    vga_rig(), frame.images, static_cast<fusion::Sampling>(state.range(0)))
                    .pixels());
    state.counters["per_keyframe"] = benchmark::Counter(
        kNumKeyframes, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(depth_view)
    ->Arg(static_cast<int>(fusion::Sampling::Full))
    ->Arg(static_cast<int>(fusion::Sampling::Half))
    ->Unit(benchmark::kMillisecond);

// Step 8 on what the keyframes gave. `of_limit`: the time in which distances, weights and views
// could be read once from memory, of that which the mesh takes.
void extract(benchmark::State& state,
             types::Mesh (*mesher)(const fusion::SignedDistanceField&,
                                   const mesh::MeshingSettings&)) {
    constexpr double kBytesPerVoxel = 6.0;
    fusion::VolumeSettings settings;
    settings.rig = vga_rig();
    settings.voxel_m = kVoxel_m;
    settings.num_threads = 1;
    fusion::TsdfVolume volume(settings);
    for (const DeepKeyframe& frame : keyframes()) volume.integrate(frame.keyframe, frame.images);
    const auto field = volume.field(1);
    const double num_voxels = static_cast<double>(fusion::kBlockSamples * field->blocks().size());
    mesh::MeshingSettings meshing;
    meshing.num_threads = 1;
    std::size_t num_triangles = 0;
    const double run_s = bench::measure(state, "voxels", num_voxels, [&] {
        num_triangles = mesher(*field, meshing).triangles.size();
    });
    state.counters["triangles"] = static_cast<double>(num_triangles);
    state.counters["of_limit"] = kBytesPerVoxel * num_voxels / bench::bytes_read_per_s() / run_s;
}

void extract_by_surface_nets(benchmark::State& state) { extract(state, mesh::surface_nets); }
BENCHMARK(extract_by_surface_nets)->Unit(benchmark::kMillisecond);

void extract_by_marching_cubes(benchmark::State& state) { extract(state, mesh::marching_cubes); }
BENCHMARK(extract_by_marching_cubes)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace divemesh::bench
