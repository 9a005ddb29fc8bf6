#pragma once

#include <string>

#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::report {

// A page in one file on which areas are drawn over the mosaic of a reconstruction, and saved as
// what `divemesh measure --areas` reads: each point with the height of the surface there. Throws
// Error{NotFound} when the reconstruction has no mosaic, Error{BadData} for one that is damaged.
std::string drawing_page(const io::ReconstructionFolder& model);

}  // namespace divemesh::report
