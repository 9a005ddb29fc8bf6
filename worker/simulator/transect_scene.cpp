#include <cmath>

#include "worker/simulator/reef_parts.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/scene_parts.hpp"

// The transect scene: a strip of reef along x, as long as the path over it. Frame of the place: the
// path begins over x = 0. The position of every object depends only on the seed, so that a longer
// path sees the same and more.
namespace divemesh::simulator {
namespace {

constexpr double kHeight_m = 2.0;
constexpr float kHalfWidth_m = 4.5F;  // to the side; the water's visibility ends there
constexpr float kBehind_m = 2.0F;
constexpr float kAhead_m = 7.0F;  // beyond the end of the path
constexpr int kCoralsPerMeter = 9;
constexpr float kHidden_m = 0.05F;  // ground this far below the other ground is hidden

void add_ground(SceneBuilder& builder, const Rectangle& area) {
    const NoiseField& noise = builder.noise();
    const auto rock = [&](float x, float y) { return reef_rock_height(noise, x, y); };
    const auto sand = [&](float x, float y) { return reef_sand_height(noise, x, y); };
    builder.add(
        "rock",
        Material::Coral,
        make_height_field(area,
                          0.03F,
                          rock,
                          [&](float x, float y) { return rock(x, y) < sand(x, y) - kHidden_m; }),
        place_at({0, 0, 0}));
    builder.add(
        "sand",
        Material::Sand,
        make_height_field(area,
                          0.035F,
                          sand,
                          [&](float x, float y) { return sand(x, y) < rock(x, y) - kHidden_m; }),
        place_at({0, 0, 0}));
}

void add_corals(SceneBuilder& builder, const Rectangle& area) {
    const auto first_m = static_cast<int>(area.min_x);
    const auto last_m = static_cast<int>(area.max_x);
    for (int meter = first_m; meter < last_m; ++meter) {
        base::RandomRow random(base::hash64(builder.seed(), 0x636f72616cULL, meter));
        for (int i = 0; i < kCoralsPerMeter; ++i) {
            const float x = draw(random, meter, meter + 1.0);
            const float y = draw(random, -kHalfWidth_m + 0.3, kHalfWidth_m - 0.3);
            add_coral(builder, random, kCoralsPerMeter * (meter - first_m) + i, x, y);
        }
    }
}

// Adds a scale bar or a block every 2 m, beside the path.
void add_known_lengths(SceneBuilder& builder, double length_m) {
    const auto num = static_cast<int>(0.5 * length_m) + 1;
    for (int i = 0; i < num; ++i) {
        base::RandomRow random(base::hash64(builder.seed(), 0x626172ULL, i));
        const float x = 2.0F * static_cast<float>(i) + 1.5F + draw(random, -0.4, 0.4);
        const float y = draw(random, -1.0, 1.0);
        const auto T =
            place_at({x, y, reef_height(builder.noise(), x, y) + 0.04F}, draw(random, -3.1, 3.1));
        if (i % 2 == 0)
            add_scale_bar(builder,
                          "scale_bar_" + std::to_string(i / 2),
                          0.2F * static_cast<float>(3 + i / 2 % 3),
                          T);
        else
            add_measured_box(
                builder, "block_" + std::to_string(i / 2), Material::Rock, {0.4F, 0.3F, 0.25F}, T);
    }
}

}  // namespace

Scene make_transect_scene(std::uint64_t seed, int year, double length_m) {
    SceneBuilder builder(seed, year, place_at({0.0F, 0.0F, 0.3F}, 0.0F));
    const Rectangle area = {-kBehind_m,
                            std::ceil(static_cast<float>(length_m)) + kAhead_m,
                            -kHalfWidth_m,
                            kHalfWidth_m};
    add_ground(builder, area);
    add_corals(builder, area);
    add_known_lengths(builder, length_m);
    SurveyPath path;
    path.straight = true;
    path.center_world = {0.0, 0.0, kHeight_m};
    path.look_yaw = 0.2;
    path.look_pitch = 0.78;
    path.speed_m_s = 0.27;
    return builder.finish(path, 11.0);
}

}  // namespace divemesh::simulator
