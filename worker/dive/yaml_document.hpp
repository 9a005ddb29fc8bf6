#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include <yaml-cpp/yaml.h>

// YAML of strangers, and the values in it. All throw YAML::Exception, with the line where they know
// it.
namespace divemesh::dive {

// Parses the first document. Aliases, anchors, keys stated twice, more than `max_nodes` values and
// nesting deeper than 8 are rejected before any object is built. Of OpenCV's files the first line
// is not valid YAML and passed over.
YAML::Node load_yaml(std::string_view text, int max_nodes);

// Returns a finite number.
double number(const YAML::Node& node);

// Returns a list of numbers, or of nested lists, as one list; of a matrix {rows, cols, data} its
// data; {} where the key is missing.
std::vector<double> numbers_at(const YAML::Node& root, const std::string& key);

// Returns nullopt where the key is missing.
std::optional<double> number_at(const YAML::Node& root, const std::string& key);

// Returns "" where the key is missing or is no single value.
std::string text_at(const YAML::Node& root, const std::string& key);

// Returns a transform of four rows, the last of which may be left out; nullopt where the key is
// missing.
std::optional<Eigen::Matrix4d> matrix_at(const YAML::Node& root, const std::string& key);

}  // namespace divemesh::dive
