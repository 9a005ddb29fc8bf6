#pragma once

#include <vector>

#include "worker/reef/height_grid.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

// Heights of the highest surface for points that have none. Where no surface was seen the height is
// that of the surroundings.
class GroundHeights {
public:
    // Samples the surface where polygons are over it. Throws Error{BadData} if none of them is.
    GroundHeights(const types::Mesh& mesh, const std::vector<Polygon>& polygons);

    double at(const Eigen::Vector2d& p_world) const;  // m

private:
    HeightGrid grid_;
};

}  // namespace divemesh::reef
