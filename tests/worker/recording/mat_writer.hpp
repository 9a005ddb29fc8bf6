#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <matio.h>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace divemesh::recording {

// A value that libmatio writes: numbers, a text, or a struct of them.
struct WrittenMat {
    std::variant<Eigen::MatrixXd, std::string, std::map<std::string, WrittenMat>> value;
};

using WrittenStruct = std::map<std::string, WrittenMat>;

// Returns a value as libmatio has it, which the caller frees.
inline matvar_t* mat_variable(const std::string& name, const WrittenMat& written) {
    if (const auto* matrix = std::get_if<Eigen::MatrixXd>(&written.value)) {
        std::size_t size[2] = {static_cast<std::size_t>(matrix->rows()),
                               static_cast<std::size_t>(matrix->cols())};
        Eigen::MatrixXd numbers = *matrix;  // by columns, as Matlab has them
        return Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, numbers.data(), 0);
    }
    if (const auto* text = std::get_if<std::string>(&written.value)) {
        std::size_t size[2] = {1, text->size()};
        std::string letters = *text;
        return Mat_VarCreate(name.c_str(), MAT_C_CHAR, MAT_T_UTF8, 2, size, letters.data(), 0);
    }
    const auto& fields = std::get<WrittenStruct>(written.value);
    std::vector<const char*> names;
    for (const auto& [field, value] : fields) names.push_back(field.c_str());
    std::size_t size[2] = {1, 1};
    matvar_t* variable = Mat_VarCreateStruct(
        name.c_str(), 2, size, names.data(), static_cast<unsigned>(names.size()));
    for (const auto& [field, value] : fields)
        Mat_VarSetStructFieldByName(variable, field.c_str(), 0, mat_variable(field, value));
    return variable;
}

// Writes variables as a MAT-file of version 5.
inline void write_mat(const std::filesystem::path& file,
                      const WrittenStruct& variables,
                      matio_compression compression) {
    const std::unique_ptr<mat_t, int (*)(mat_t*)> mat(
        Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5), &Mat_Close);
    if (!mat) throw std::runtime_error("libmatio cannot write " + file.string());
    for (const auto& [name, value] : variables) {
        const std::unique_ptr<matvar_t, void (*)(matvar_t*)> variable(mat_variable(name, value),
                                                                      &Mat_VarFree);
        if (Mat_VarWrite(mat.get(), variable.get(), compression) != 0)
            throw std::runtime_error("libmatio does not write " + name);
    }
}

}  // namespace divemesh::recording
