#pragma once

#include <string>
#include <vector>

namespace divemesh::cli {

// What `divemesh import` is given.
enum class ImportKind { Messages, Videos, Images, CalibrationAlone };

// Throws Error{InvalidArgument} if one of the options that a user gave, such as "--layout", is not
// used for what is imported. The message names the option, what was found, and the options of it.
// `recording` is its path, "" for a calibration alone.
void check_options_apply(const std::vector<std::string>& given,
                         ImportKind kind,
                         const std::string& recording);

}  // namespace divemesh::cli
