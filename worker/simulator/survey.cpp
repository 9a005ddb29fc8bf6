#include "worker/simulator/survey.hpp"

#include <numbers>

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

void thicken(Water& water, double times) {
    water.attenuation_per_m *= static_cast<float>(times);
    water.backscatter_per_m *= static_cast<float>(times);
}

Survey first_survey(const SimulateOptions& options, const SurveyPath& of_scene, WaterKind water) {
    Survey survey{options.seed, of_scene, make_water(water)};
    survey.path.speed_m_s *= options.speed;
    survey.path.sway = options.sway;
    survey.path.swing_rad_s = options.swing_deg_s * std::numbers::pi / 180.0;
    survey.water.exposure *= static_cast<float>(options.light);
    thicken(survey.water, options.turbidity);
    return survey;
}

}  // namespace

Survey plan_survey(const SimulateOptions& options, const SurveyPath& of_scene, WaterKind water) {
    Survey survey = first_survey(options, of_scene, water);
    if (options.year == 1 && options.survey == 1) return survey;
    survey.seed = base::hash64(options.seed, 0x737572766579ULL, options.year, options.survey);
    base::RandomRow random(survey.seed);
    SurveyPath& path = survey.path;
    path.center_world.x() += random.uniform(-0.2, 0.2);
    path.center_world.y() += random.uniform(-0.2, 0.2);
    path.center_world.z() += random.uniform(0.0, 0.25);
    path.start_angle += random.uniform(-0.15, 0.15);
    path.look_yaw += random.uniform(-0.07, 0.07);
    path.look_pitch += random.uniform(-0.05, 0.05);
    thicken(survey.water, random.uniform(0.87, 1.18));
    return survey;
}

}  // namespace divemesh::simulator
