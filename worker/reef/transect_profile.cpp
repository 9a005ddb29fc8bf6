#include "worker/reef/transect_profile.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::reef {
namespace {

constexpr double kStep_m = 0.005;  // every spacing of the options is a multiple of it

}  // namespace

std::vector<TransectSegment> segments_of(const std::vector<Eigen::Vector3d>& line,
                                         const Eigen::Vector3d& normal) {
    std::vector<TransectSegment> segments;
    double along = 0.0;
    std::int64_t next = 0;  // step
    for (std::size_t i = 1; i < line.size(); ++i) {
        TransectSegment segment;
        segment.plane = plane_along(line[i - 1], line[i], normal);
        const double length = segment.plane.outline[1].x() - segment.plane.outline[0].x();
        constexpr double kSlack_m = 1e-6;
        const auto end =
            static_cast<std::int64_t>(std::floor((along + length + kSlack_m) / kStep_m));
        segment.first_along_m = static_cast<double>(next) * kStep_m;
        segment.shape.origin_m = {segment.first_along_m - along, 0.0};
        segment.shape.spacing_m = kStep_m;
        segment.shape.num_columns = static_cast<int>(std::max<std::int64_t>(0, end - next + 1));
        segment.shape.num_rows = 1;
        segment.datum_m = normal.dot(line[i - 1] - line[0]);
        segments.push_back(segment);
        next = std::max(next, end + 1);
        along += length;
    }
    return segments;
}

Profile profile_of(const std::vector<TransectSegment>& segments,
                   const std::vector<SurfacePatch>& patches,
                   const Places& places) {
    Profile profile;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const HeightGrid heights =
            sample_heights(places[i], patches[i].triangles, segments[i].shape);
        for (int k = 0; k < segments[i].shape.num_columns; ++k)
            profile.push_back(
                {segments[i].first_along_m + k * kStep_m,
                 heights.is_seen(k, 0) ? heights.at(k, 0) + segments[i].datum_m : kUnseen_m});
    }
    return profile;
}

Profile every(const Profile& profile, double spacing_m) {
    const auto step = static_cast<std::size_t>(std::lround(spacing_m / kStep_m));
    Profile links;
    for (std::size_t i = 0; i < profile.size(); i += step) links.push_back(profile[i]);
    return links;
}

Profile blurred(const Profile& profile, double side_m) {
    const auto radius = static_cast<std::ptrdiff_t>(std::lround(0.5 * side_m / kStep_m));
    Profile out = profile;
    const auto num = static_cast<std::ptrdiff_t>(profile.size());
    for (std::ptrdiff_t i = 0; i < num; ++i) {
        if (!(profile[i].height_m > kUnseen_m)) continue;
        double sum = 0.0;
        int num_seen = 0;
        for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - radius);
             k <= std::min(num - 1, i + radius);
             ++k) {
            if (!(profile[k].height_m > kUnseen_m)) continue;
            sum += profile[k].height_m;
            ++num_seen;
        }
        out[i].height_m = sum / num_seen;
    }
    return out;
}

Profile gaps_filled(Profile profile) {
    std::size_t last = profile.size();  // last seen index
    for (std::size_t i = 0; i < profile.size(); ++i) {
        if (!(profile[i].height_m > kUnseen_m)) continue;
        for (std::size_t k = last + 1; k < i; ++k) {
            const double share = static_cast<double>(k - last) / static_cast<double>(i - last);
            profile[k].height_m = std::lerp(profile[last].height_m, profile[i].height_m, share);
        }
        last = i;
    }
    return profile;
}

double coverage_of(const Profile& profile) {
    const auto num = std::count_if(profile.begin(), profile.end(), [](const ProfilePoint& point) {
        return point.height_m > kUnseen_m;
    });
    return profile.empty() ? 0.0 : static_cast<double>(num) / static_cast<double>(profile.size());
}

}  // namespace divemesh::reef
