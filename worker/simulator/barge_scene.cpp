#include <array>
#include <cmath>

#include "worker/simulator/scene.hpp"
#include "worker/simulator/scene_parts.hpp"

// The barge scene: a flat-bottomed hull on sand. Frame of the place: x along the keel, z = 0 the
// deck.
namespace divemesh::simulator {
namespace {

constexpr float kHalfLength_m = 4.5F;
constexpr float kHalfWidth_m = 1.6F;
constexpr float kSand_m = -0.8F;
constexpr float kRibSpacing_m = 0.75F;
constexpr float kDeckStep_m = 0.02F;
constexpr Rectangle kHatch = {0.3F, 1.5F, -0.45F, 0.45F};

bool in_hatch(float x, float y) {
    return x > kHatch.min_x && x < kHatch.max_x && y > kHatch.min_y && y < kHatch.max_y;
}

Shape rough_box(const SceneBuilder& builder, const Eigen::Vector3f& size_m, float amplitude_m) {
    Shape shape = make_box(size_m, 0.022F);
    roughen(shape, builder.noise(), amplitude_m, 0.12F);
    return shape;
}

void add_deck(SceneBuilder& builder) {
    const NoiseField& noise = builder.noise();
    const auto height = [&](float x, float y) {
        // Distance from the joint between planks.
        const float seam = std::abs(std::remainder(y + 0.12F, 0.24F));
        const float joint = seam < 0.012F ? -0.012F : 0.0F;
        const Eigen::Vector3f p(x, y, 0.0F);
        return joint + 0.012F * noise.fractal(p, 0.6F, 2)[0] +
               0.006F * noise.fractal(p, 0.1F, 2)[1];
    };
    builder.add("deck",
                Material::Deck,
                make_height_field({-kHalfLength_m, kHalfLength_m, -kHalfWidth_m, kHalfWidth_m},
                                  kDeckStep_m,
                                  height,
                                  in_hatch),
                place_at({0, 0, 0}));
}

void add_hull(SceneBuilder& builder) {
    const float height_m = 1.1F;
    for (const float side : {-1.0F, 1.0F}) {
        const std::string end = side < 0.0F ? "_0" : "_1";
        builder.add("hull_side" + end,
                    Material::Iron,
                    rough_box(builder, {2.0F * kHalfLength_m, 0.06F, height_m}, 0.01F),
                    place_at({0.0F, side * (kHalfWidth_m - 0.01F), -0.5F * height_m - 0.03F}));
        builder.add("hull_end" + end,
                    Material::Iron,
                    rough_box(builder, {0.06F, 2.0F * kHalfWidth_m, height_m}, 0.01F),
                    place_at({side * (kHalfLength_m - 0.01F), 0.0F, -0.5F * height_m - 0.03F}));
        builder.add("edge_coaming" + end,
                    Material::Iron,
                    rough_box(builder, {2.0F * kHalfLength_m, 0.11F, 0.2F}, 0.004F),
                    place_at({0.0F, side * 1.5F, 0.09F}));
    }
}

void add_ribs(SceneBuilder& builder) {
    const auto num_ribs = static_cast<int>(2.0F * kHalfLength_m / kRibSpacing_m) - 1;
    for (int i = 0; i < num_ribs; ++i) {
        const float x = -kHalfLength_m + kRibSpacing_m * static_cast<float>(i + 1);
        const std::string name = "rib_" + std::to_string(i);
        if (x < kHatch.min_x - 0.2F || x > kHatch.max_x + 0.2F) {
            builder.add(name,
                        Material::Timber,
                        rough_box(builder, {0.1F, 2.9F, 0.12F}, 0.004F),
                        place_at({x, 0.0F, 0.05F}));
            continue;
        }
        for (const float side : {-1.0F, 1.0F})
            builder.add(name + (side < 0.0F ? "_0" : "_1"),
                        Material::Timber,
                        rough_box(builder, {0.1F, 0.85F, 0.12F}, 0.004F),
                        place_at({x, side * 1.02F, 0.05F}));
    }
}

void add_hatch(SceneBuilder& builder) {
    const float thick_m = 0.1F;
    const float top_m = 0.28F;
    const float length_m = kHatch.max_x - kHatch.min_x + 2.0F * thick_m;
    const float width_m = kHatch.max_y - kHatch.min_y + 2.0F * thick_m;
    const float x = 0.5F * (kHatch.min_x + kHatch.max_x);
    const float low_m = -0.25F;
    const float middle = 0.5F * (top_m + low_m);
    for (const float side : {-1.0F, 1.0F}) {
        const std::string end = side < 0.0F ? "_0" : "_1";
        builder.add("hatch_long" + end,
                    Material::Iron,
                    make_box({length_m, thick_m, top_m - low_m}, 0.02F),
                    place_at({x, side * 0.5F * (width_m - thick_m), middle}));
        builder.add("hatch_short" + end,
                    Material::Iron,
                    make_box({thick_m, width_m - 2.0F * thick_m, top_m - low_m}, 0.02F),
                    place_at({x + side * 0.5F * (length_m - thick_m), 0.0F, middle}));
    }
    const auto corner = [&](double sx, double sy) {
        return Eigen::Vector3d(x + sx * 0.5 * length_m, sy * 0.5 * width_m, top_m);
    };
    const std::string where = "outer corners of the coaming's top";
    builder.add_distance("hatch_length_port", where, corner(-1, 1), corner(1, 1));
    builder.add_distance("hatch_length_starboard", where, corner(-1, -1), corner(1, -1));
    builder.add_distance("hatch_width_aft", where, corner(-1, -1), corner(-1, 1));
    builder.add_distance("hatch_width_fore", where, corner(1, -1), corner(1, 1));
    builder.add_distance("hatch_diagonal", where, corner(-1, -1), corner(1, 1));
}

void add_seabed(SceneBuilder& builder) {
    const NoiseField& noise = builder.noise();
    const auto height = [&](float x, float y) {
        const Eigen::Vector3f p(x, y, 0.0F);
        const Eigen::Array4f wide = noise.fractal(p, 1.7F, 3);
        const float ripple = std::sin(26.0F * (x + 0.35F * y + 0.12F * wide[2]));
        return kSand_m + 0.1F * wide[0] + 0.012F * ripple + 0.01F * noise.at(p / 0.09F)[1];
    };
    const auto under_hull = [](float x, float y) {
        return std::abs(x) < kHalfLength_m - 0.2F && std::abs(y) < kHalfWidth_m - 0.2F &&
               !(x > kHatch.min_x - 1.0F && x < kHatch.max_x + 1.0F);
    };
    builder.add("sand",
                Material::Sand,
                make_height_field({-8.5F, 8.5F, -6.0F, 6.0F}, 0.04F, height, under_hull),
                place_at({0, 0, 0}));
}

void add_debris(SceneBuilder& builder, base::RandomRow& random) {
    for (int i = 0; i < 34; ++i) {
        const Eigen::Vector3f size(
            draw(random, 0.35, 1.3), draw(random, 0.07, 0.3), draw(random, 0.03, 0.09));
        const float x = draw(random, -4.2, 4.2);
        const float y = draw(random, -1.3, 1.3);
        const auto T = place_at({x, y, draw(random, 0.05, 0.15)},
                                draw(random, -3.1, 3.1),
                                draw(random, -0.1, 0.1),
                                draw(random, -0.15, 0.15));
        const Shape plank = rough_box(builder, size, 0.006F);
        const std::string name = "debris_" + std::to_string(i);
        const bool clear = !in_hatch(x + 0.3F, y) && !in_hatch(x - 0.3F, y);
        if (!clear) continue;
        if (i % 11 == 4)
            builder.add_changing(name, Material::Timber, plank, T, SceneBuilder::Fate::Lost);
        else
            builder.add(name, i % 3 ? Material::Timber : Material::Iron, plank, T);
    }
    for (int i = 0; i < 40; ++i) {
        const float x = draw(random, -7.5, 7.5);
        const float y = (i % 2 ? 1.0F : -1.0F) * draw(random, 1.9, 5.0);
        add_lump(builder,
                 "stone_" + std::to_string(i),
                 Material::Rock,
                 draw(random, 0.07, 0.28),
                 place_at({x, y, kSand_m}, draw(random, -3.1, 3.1)));
    }
}

void add_life(SceneBuilder& builder, base::RandomRow& random) {
    constexpr std::array<Material, 3> kKinds = {
        Material::Coral, Material::BranchCoral, Material::Sponge};
    for (int i = 0; i < 42; ++i) {
        const float x = draw(random, -4.3, 4.3);
        const float y = draw(random, -1.4, 1.4);
        const float size_m = draw(random, 0.07, 0.2);
        const float yaw = draw(random, -3.1, 3.1);
        if (in_hatch(x + 0.2F, y) || in_hatch(x - 0.2F, y)) continue;
        const Material kind = kKinds[static_cast<std::size_t>(i % 3)];
        const auto T = place_at({x, y, 0.02F}, yaw);
        Shape shape;
        if (kind == Material::BranchCoral) {
            shape = make_branches(1.7F * size_m, 6, 0.015F, base::hash64(builder.seed(), 77, i));
        } else {
            const float tall = kind == Material::Sponge ? 1.8F : 0.85F;
            shape = make_ellipsoid({size_m, 0.9F * size_m, tall * size_m}, 0.018F);
            roughen(shape, builder.noise(), 0.12F * size_m, 0.9F * size_m);
            roughen(shape, builder.noise(), 0.006F, 0.035F);
        }
        const std::string name = "coral_" + std::to_string(i);
        if (i % 4 == 0)
            builder.add_changing(name, kind, shape, T, SceneBuilder::Fate::Grows);
        else if (i % 10 == 7)
            builder.add_changing(name, kind, shape, T, SceneBuilder::Fate::New);
        else
            builder.add(name, kind, shape, T);
    }
}

}  // namespace

Scene make_barge_scene(std::uint64_t seed, int year) {
    base::RandomRow random(base::hash64(seed, 0x6261726765ULL));
    const auto T_world_place =
        place_at({0.1F, -0.05F, 0.7F}, 0.06F, draw(random, -0.02, 0.02), draw(random, -0.03, 0.03));
    SceneBuilder builder(seed, year, T_world_place);
    add_deck(builder);
    add_hull(builder);
    add_ribs(builder);
    add_hatch(builder);
    add_seabed(builder);
    add_debris(builder, random);
    add_life(builder, random);
    add_scale_bar(builder, "scale_bar_0", 1.0F, place_at({-2.3F, 0.35F, 0.13F}, 0.4F));
    add_scale_bar(builder, "scale_bar_1", 0.6F, place_at({2.6F, -0.5F, 0.13F}, -0.7F));
    add_scale_bar(builder, "scale_bar_2", 0.8F, place_at({0.2F, -1.05F, 0.13F}, 0.15F));
    add_measured_box(builder,
                     "crate_0",
                     Material::Wood,
                     {0.42F, 0.3F, 0.3F},
                     place_at({-0.6F, 0.75F, 0.02F}, 0.5F));
    add_measured_box(builder,
                     "crate_1",
                     Material::Wood,
                     {0.36F, 0.36F, 0.24F},
                     place_at({2.3F, 0.7F, 0.02F}, -0.3F));
    SurveyPath path;
    path.center_world = {0.1, -0.05, 2.15};
    path.semi_axis_x_m = 2.9;
    path.semi_axis_y_m = 1.15;
    path.start_angle = -1.9;
    path.look_yaw = 0.25;
    path.look_pitch = 0.72;
    path.speed_m_s = 0.27;
    return builder.finish(path, 9.0);
}

}  // namespace divemesh::simulator
