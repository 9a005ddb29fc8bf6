// How far a surface that should be a plane is from one: root mean square distance of the vertices
// of a mesh from the plane that fits them best, m; and how much of that bends its long axis: the
// same of the mean heights of slices across it. With a second argument draws the surface from the
// side, heights ten times as large, and from above, coloured by height.
//
//     plane_fit mesh.ply [image.png]

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "worker/io/ply.hpp"

namespace divemesh::bench {
namespace {

constexpr double kPixelsPerMetre = 110.0;
constexpr double kSlice_m = 0.1;
constexpr double kExaggeration = 10.0;
constexpr double kFullColour_m = 0.06;
constexpr int kMargin_px = 20;
constexpr int kSide_px = 180;

// Coordinates along the plane's long axis (with world x), across it, and off it (with world z).
std::vector<Eigen::Vector3d> in_plane(const std::vector<Eigen::Vector3f>& points) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : points) mean += p.cast<double>() / static_cast<double>(points.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& p : points) {
        const Eigen::Vector3d d = p.cast<double>() - mean;
        scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
    Eigen::Matrix3d R;
    R.row(0) = axes.eigenvectors().col(2).transpose();
    R.row(2) = axes.eigenvectors().col(0).transpose();
    if (R(0, 0) < 0.0) R.row(0) *= -1.0;
    if (R(2, 2) < 0.0) R.row(2) *= -1.0;
    R.row(1) = R.row(2).cross(R.row(0));
    std::vector<Eigen::Vector3d> result;
    for (const auto& p : points) result.emplace_back(R * (p.cast<double>() - mean));
    return result;
}

double plane_rms_m(const std::vector<Eigen::Vector3d>& points) {
    double squares = 0.0;
    for (const auto& p : points) squares += p.z() * p.z();
    return std::sqrt(squares / static_cast<double>(points.size()));
}

double along_rms_m(const std::vector<Eigen::Vector3d>& points) {
    struct Slice {
        double sum = 0.0;
        int count = 0;
    };
    std::map<int, Slice> slices;
    for (const auto& p : points) {
        Slice& slice = slices[static_cast<int>(std::floor(p.x() / kSlice_m))];
        slice.sum += p.z();
        ++slice.count;
    }
    double squares = 0.0;
    for (const auto& [index, slice] : slices)
        squares += slice.sum * slice.sum / slice.count;  // a slice weighs as its vertices do
    return std::sqrt(squares / static_cast<double>(points.size()));
}

cv::Scalar colour_of(double height_m) {
    const double share = std::clamp(height_m / kFullColour_m, -1.0, 1.0);
    const double pale = 255.0 * (1.0 - std::abs(share));
    return share > 0.0 ? cv::Scalar(pale, pale, 255.0) : cv::Scalar(255.0, pale, pale);
}

void draw(const std::string& file, const std::vector<Eigen::Vector3d>& points, double rms_m) {
    Eigen::AlignedBox3d box;
    for (const auto& p : points) box.extend(p);
    const int width = static_cast<int>(box.sizes().x() * kPixelsPerMetre) + 2 * kMargin_px;
    const int top_px = static_cast<int>(box.sizes().y() * kPixelsPerMetre) + 2 * kMargin_px;
    cv::Mat image(kSide_px + top_px, width, CV_8UC3, cv::Scalar::all(255));
    const int middle = kSide_px / 2;
    cv::line(image, {0, middle}, {width, middle}, cv::Scalar::all(170), 1);
    for (const auto& p : points) {
        const int u = kMargin_px + static_cast<int>((p.x() - box.min().x()) * kPixelsPerMetre);
        const int side = middle - static_cast<int>(p.z() * kExaggeration * kPixelsPerMetre);
        const int above =
            kSide_px + kMargin_px + static_cast<int>((box.max().y() - p.y()) * kPixelsPerMetre);
        if (side >= 0 && side < kSide_px) image.at<cv::Vec3b>(side, u) = cv::Vec3b(120, 70, 20);
        cv::circle(image, {u, above}, 1, colour_of(p.z()), cv::FILLED);
    }
    char text[80];
    std::snprintf(
        text, sizeof text, "side, heights x%.0f: RMS %.1f mm", kExaggeration, 1e3 * rms_m);
    cv::putText(
        image, text, {kMargin_px, 16}, cv::FONT_HERSHEY_SIMPLEX, 0.45, {0, 0, 0}, 1, cv::LINE_AA);
    cv::imwrite(file, image);
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    if (argc < 2) {
        std::cerr << "plane_fit mesh.ply [image.png]\n";
        return 2;
    }
    const auto points = bench::in_plane(io::read_ply(argv[1]).vertices);
    const double rms_m = bench::plane_rms_m(points);
    if (argc > 2) bench::draw(argv[2], points, rms_m);
    std::cout << "{\"num_vertices\": " << points.size() << ", \"plane_rms_m\": " << rms_m
              << ", \"along_rms_m\": " << bench::along_rms_m(points) << "}\n";
    return 0;
}
