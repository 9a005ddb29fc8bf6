#pragma once

namespace divemesh::camera {

double area_m2();

}  // namespace divemesh::camera
