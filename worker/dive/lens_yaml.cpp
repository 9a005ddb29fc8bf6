#include "worker/dive/lens_yaml.hpp"

#include <algorithm>

namespace divemesh::dive {
namespace {

// Of pinhole cameras with distortion and of omnidirectional ones, as OpenCV and Kalibr write them;
// fewer say that a file is damaged.
constexpr std::size_t kMinCoefficients = 4;

bool is_without_distortion(const SensorYaml& yaml) {
    return yaml.distortion_model == "none" || yaml.distortion_model.empty();
}

bool has_names(const camera::LensModel& model, const SensorYaml& yaml) {
    const auto& names = model.distortion_models;
    return model.camera_model == yaml.camera_model &&
           std::find(names.begin(), names.end(), yaml.distortion_model) != names.end();
}

std::size_t num_distortion_coefficients(const camera::LensModel& model) {
    return model.num_coefficients - model.leading.size();
}

bool holds_all(const camera::LensModel& model, const SensorYaml& yaml) {
    if (is_without_distortion(yaml)) return true;
    const auto& k = yaml.distortion_coefficients;
    if (k.size() < kMinCoefficients) return false;
    const auto end = std::min(k.size(), num_distortion_coefficients(model));
    return std::all_of(k.begin() + static_cast<std::ptrdiff_t>(end), k.end(), [](double value) {
        return value == 0.0;
    });
}

}  // namespace

const camera::LensModel* camera_model_of(const SensorYaml& yaml) {
    for (const camera::LensModel& model : camera::lens_models())
        if (model.camera_model == yaml.camera_model) return &model;
    return nullptr;
}

const camera::LensModel* lens_model_of(const SensorYaml& yaml) {
    const camera::LensModel* smallest = nullptr;
    for (const camera::LensModel& model : camera::lens_models()) {
        if (!has_names(model, yaml) || !holds_all(model, yaml)) continue;
        if (!smallest || model.num_coefficients < smallest->num_coefficients) smallest = &model;
    }
    return smallest;
}

bool is_distortion_known(const SensorYaml& yaml) {
    const auto models = camera::lens_models();
    return std::any_of(models.begin(), models.end(), [&](const camera::LensModel& model) {
        return has_names(model, yaml);
    });
}

std::string intrinsics_names(const camera::LensModel& model) {
    std::string names;
    for (const camera::LeadingCoefficient& coefficient : model.leading)
        names.append(coefficient.name).append(", ");
    return names + "fu, fv, cu, cv";
}

void read_lens(const SensorYaml& yaml, const camera::LensModel& model, types::Camera& camera) {
    camera.distortion = model.distortion;
    camera.distortion_coefficients = {};
    const auto leading = static_cast<std::ptrdiff_t>(model.leading.size());
    const auto pinhole = yaml.intrinsics.begin() + leading;
    auto next = std::copy(yaml.intrinsics.begin(), pinhole, camera.distortion_coefficients.begin());
    if (!is_without_distortion(yaml)) {
        const auto& k = yaml.distortion_coefficients;
        std::copy_n(k.begin(), std::min(k.size(), num_distortion_coefficients(model)), next);
    }
    const double factor = model.focal_factor(camera.distortion_coefficients);
    camera.fx_px = pinhole[0] / factor;
    camera.fy_px = pinhole[1] / factor;
    camera.cx_px = pinhole[2];
    camera.cy_px = pinhole[3];
}

void state_lens(const types::Camera& camera, SensorYaml& yaml) {
    const camera::LensModel& model = camera::lens_model(camera.distortion);
    const auto& k = camera.distortion_coefficients;
    const auto first = k.begin() + static_cast<std::ptrdiff_t>(model.leading.size());
    const double factor = model.focal_factor(k);
    yaml.camera_model = model.camera_model;
    yaml.intrinsics.assign(k.begin(), first);
    for (const double value :
         {camera.fx_px * factor, camera.fy_px * factor, camera.cx_px, camera.cy_px})
        yaml.intrinsics.push_back(value);
    yaml.distortion_model = model.distortion_models.front();
    yaml.distortion_coefficients.assign(
        first, k.begin() + static_cast<std::ptrdiff_t>(model.num_coefficients));
}

}  // namespace divemesh::dive
