#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::compare {

// Where the middle of a marker lies, as a reconstruction found it: a fixed point between dives.
struct MarkerPosition {
    int id = 0;
    std::string family;                                           // tag36h11, ...
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();            // m
    Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  // of p_world
};

// Of the section `markers` of metrics.json, by rising id; empty when nobody looked for markers or
// none was found. Markers of a piece that is not tied to the largest one are left out. Throws
// Error{BadData} when the section is not as schemas/metrics.schema.json has it.
std::vector<MarkerPosition> marker_positions(const io::ReconstructionFolder& folder);

}  // namespace divemesh::compare
