#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"

namespace divemesh::recording {

// The names of folders that a user states; "" where the names of the images decide.
struct NamedFolders {
    std::string left;
    std::string right;
};

// An image of a camera.
struct SidedImage {
    std::string name;  // in the recording
    std::string stem;  // its own name without extension and without the word for the camera
};

// The images of both cameras of a recording, in the order of their names.
struct CameraSides {
    std::vector<SidedImage> left;
    std::vector<SidedImage> right;
    std::string rule;  // how they were told apart, for people: "left and right"
};

// Tells the images of the left camera from those of the right one by the words in their names,
// folders first of all: left and right, L and R, cam0 and cam1, image_2 and image_3, _0 and _1 at
// the end. Images of neither are reported. Throws Error{InvalidArgument} that says what to do if no
// word fits, or there are several recordings.
CameraSides find_camera_sides(const std::vector<std::string>& images,
                              const NamedFolders& named,
                              dive::FindingLog& findings);

// Returns the number behind "image" or "cam" in the folders of an image, which is that of its
// camera: 2 of "image_02/data/0000000000.png".
std::optional<int> camera_number(std::string_view image);

}  // namespace divemesh::recording
