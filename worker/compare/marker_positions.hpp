#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::compare {

// The centre of a marker as a reconstruction located it: a fixed point between dives.
struct MarkerPosition {
    int id = 0;
    std::string family;                                           // tag36h11, ...
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();            // m
    Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  // of p_world
};

// Reads the section `markers` of metrics.json, in order of id; empty if no markers were searched
// for or found. Leaves out markers of a segment that is not connected to the largest one. Throws
// Error{BadData} if the section does not fit schemas/metrics.schema.json.
std::vector<MarkerPosition> marker_positions(const io::ReconstructionFolder& folder);

}  // namespace divemesh::compare
