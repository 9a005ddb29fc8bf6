#pragma once

#include <string_view>
#include <yaml-cpp/yaml.h>

namespace divemesh::recording {

// Parses XML as cv::FileStorage writes it: elements of elements or of words, of which attributes
// are passed over. Returns the values below <opencv_storage>, a list where an element holds several
// words. Throws YAML::ParserException with the line if it is other XML, nested deeper than 8 or of
// more than 1000 elements.
YAML::Node parse_opencv_xml(std::string_view text);

}  // namespace divemesh::recording
