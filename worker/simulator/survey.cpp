#include "worker/simulator/survey.hpp"

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {

Survey plan_survey(const SimulateOptions& options, const SurveyPath& of_scene, WaterKind water) {
    Survey survey{options.seed, of_scene, make_water(water)};
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
    const auto thicker = static_cast<float>(random.uniform(0.87, 1.18));
    survey.water.attenuation_per_m *= thicker;
    survey.water.backscatter_per_m *= thicker;
    return survey;
}

}  // namespace divemesh::simulator
