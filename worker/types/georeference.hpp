#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "worker/types/geographic_position.hpp"

namespace divemesh::types {

// How the positions of one source, of control points or of a DVL agree with the path.
struct SourceAgreement {
    std::string name;  // position0, control_points, velocity0
    std::string kind;  // usbl, gps_float, surface_fix, control_points, dvl
    int epsg = 0;      // in which they were stated; 0: they have no place
    std::int64_t num_rows = 0;
    std::int64_t num_without_path = 0;  // of other times than the path, or of tags not found
    std::int64_t num_rejected = 0;      // more than four sigmas off
    double rms_m = 0.0;                 // of the residuals of the others, horizontal
    double sigma_factor = 1.0;          // on the stated sigmas, by the spread of the residuals
    // By which the sigmas grow further, because errors of neighbouring rows are alike.
    double correlation_factor = 1.0;
    std::string left_out;  // why none of it was used; "": it was used

    std::int64_t num_used() const {
        return left_out.empty() ? num_rows - num_without_path - num_rejected : 0;
    }
};

// Where a result lies on the earth.
struct GeoReference {
    std::vector<SourceAgreement> sources;
    // Position of the world's origin; nullopt: no source tells it.
    std::optional<GeographicPosition> position;
    int utm_epsg = 0;
    Eigen::Vector3d utm_m = Eigen::Vector3d::Zero();    // the same; z: height, if it is known
    Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  // along easting, northing and up
    bool has_height = false;
    double heading_sigma_deg = 0.0;
    bool path_joined = false;  // the path was corrected too
    // On the sigmas of the path, by how far the sources moved it: 1 if these are as stated.
    double path_sigma_factor = 1.0;
    double largest_correction_m = 0.0;
    int num_joined_segments = 0;  // that were put into the world of the first
    double joined_sigma_m = 0.0;  // the largest, of their places relative to the first
};

}  // namespace divemesh::types
