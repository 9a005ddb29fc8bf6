#pragma once

#include "worker/texture/view_field.hpp"

namespace divemesh::texture {

// Gives whole charts, which are connected triangles of one view, the view of a neighbouring chart
// where that lowers the energy, until no chart changes. Steps of single triangles cannot do that.
void merge_charts(const ViewField& field, FaceViews& views);

}  // namespace divemesh::texture
