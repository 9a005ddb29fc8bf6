#pragma once

#include <string>

#include "worker/io/reconstruction_folder.hpp"
#include "worker/reef/outline_file.hpp"

namespace divemesh::reef {

// Moves the points of outlines into the world of a reconstruction, x and y in m. Throws
// Error{InvalidArgument} if they are on the earth and the position of the dive is not known, or
// Error{BadData} if they were drawn on another image than the mosaic.
void place_outlines(OutlineFile& file, const io::ReconstructionFolder& reconstruction);

// Returns the words for the coordinates of a file, for messages.
std::string coordinates_text(const OutlineFile& file);

}  // namespace divemesh::reef
