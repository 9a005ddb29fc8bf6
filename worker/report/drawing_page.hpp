#pragma once

#include <filesystem>
#include <string>

#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::report {

// Returns a page in one file on which a user draws areas over the mosaic of a reconstruction. It
// saves them as `divemesh measure --areas` reads them: each point with the height of the surface
// there. Throws Error{NotFound} if the reconstruction has no mosaic, Error{BadData} if that is
// damaged.
std::string drawing_page(const io::ReconstructionFolder& model);
// Writes that page to a file.
void write_drawing_page(const io::ReconstructionFolder& model, const std::filesystem::path& path);

}  // namespace divemesh::report
