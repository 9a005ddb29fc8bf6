#include <algorithm>
#include <string>
#include <vector>

#include "schemas/enum_text.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/camera/port_names.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::simulator {
namespace {

constexpr EnumText<SceneKind> kSceneTexts[] = {{SceneKind::Tank, "tank"},
                                               {SceneKind::Barge, "barge"},
                                               {SceneKind::Reef, "reef"},
                                               {SceneKind::Bed, "bed"},
                                               {SceneKind::Transect, "transect"}};
constexpr EnumText<WaterKind> kWaterTexts[] = {{WaterKind::None, "none"},
                                               {WaterKind::Clear, "clear"},
                                               {WaterKind::Green, "green"},
                                               {WaterKind::Turbid, "turbid"}};
}  // namespace

std::string_view to_string(SceneKind kind) { return enum_to_text(kSceneTexts, kind); }
std::string_view to_string(WaterKind kind) { return enum_to_text(kWaterTexts, kind); }

SceneKind scene_kind_from_string(std::string_view text) {
    return enum_from_text<SceneKind>(kSceneTexts, text, "scene");
}

WaterKind water_kind_from_string(std::string_view text) {
    return enum_from_text<WaterKind>(kWaterTexts, text, "water");
}

types::Port::Shape port_shape_from_string(std::string_view text) {
    std::vector<EnumText<types::Port::Shape>> names;
    for (const std::string_view name : camera::kPortNames)
        names.push_back({*camera::port_shape(name), name});
    return enum_from_text<types::Port::Shape>(names, text, "port");
}

types::PositionKind position_kind_from_string(std::string_view text) {
    std::string word(text);
    std::ranges::replace(word, '-', '_');
    return enum_from_text<types::PositionKind>(types::kPositionKindTexts, word, "positions");
}

types::Distortion lens_from_string(std::string_view text) {
    std::vector<EnumText<types::Distortion>> names;
    for (const camera::LensModel& model : camera::lens_models())
        names.push_back({model.distortion, model.name});
    return enum_from_text<types::Distortion>(names, text, "camera model");
}

}  // namespace divemesh::simulator
