#include "worker/simulator/surface_color.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

// The appearance of a material: two tones of the bare surface, patches of growth or stains,
// blotches, and flecks of a centimetre or less.
struct Appearance {
    Rgb tone_a;
    Rgb tone_b;
    Rgb patch;
    Rgb blotch;
    Rgb fleck;
    float patch_level;  // noise level above which there is a patch: lower covers more
    float blotch_level;
    float fleck_level;
    float grain;         // strength of the finest octaves
    float wavelength_m;  // of the widest octave
};

// clang-format off
const Appearance kDeck     = {{.30F,.25F,.17F}, {.16F,.17F,.13F}, {.20F,.30F,.14F}, {.48F,.33F,.15F}, {.72F,.68F,.58F}, 0.25F, 0.42F, 0.55F, .55F, 0.9F};
const Appearance kTimber   = {{.26F,.20F,.13F}, {.13F,.12F,.10F}, {.24F,.30F,.16F}, {.42F,.30F,.17F}, {.66F,.62F,.54F}, 0.30F, 0.45F, 0.55F, .60F, 0.6F};
const Appearance kIron     = {{.28F,.15F,.08F}, {.17F,.14F,.11F}, {.34F,.32F,.20F}, {.42F,.24F,.10F}, {.68F,.62F,.52F}, 0.28F, 0.40F, 0.58F, .60F, 0.6F};
const Appearance kSand     = {{.52F,.47F,.36F}, {.40F,.36F,.28F}, {.30F,.28F,.20F}, {.60F,.56F,.47F}, {.14F,.12F,.10F}, 0.45F, 0.50F, 0.50F, .55F, 0.7F};
const Appearance kRock     = {{.30F,.28F,.24F}, {.18F,.18F,.16F}, {.30F,.20F,.24F}, {.22F,.30F,.15F}, {.66F,.63F,.58F}, 0.30F, 0.40F, 0.52F, .60F, 0.5F};
const Appearance kCoral    = {{.44F,.37F,.22F}, {.13F,.12F,.08F}, {.42F,.22F,.26F}, {.24F,.34F,.18F}, {.74F,.70F,.60F}, 0.24F, 0.34F, 0.46F, .75F, 0.5F};
const Appearance kBranch   = {{.52F,.42F,.26F}, {.40F,.28F,.20F}, {.60F,.50F,.40F}, {.36F,.28F,.30F}, {.80F,.76F,.66F}, 0.35F, 0.45F, 0.50F, .55F, 0.12F};
const Appearance kSponge   = {{.55F,.40F,.08F}, {.42F,.28F,.06F}, {.34F,.20F,.10F}, {.62F,.50F,.16F}, {.12F,.09F,.05F}, 0.35F, 0.45F, 0.48F, .60F, 0.2F};
const Appearance kBrick    = {{.40F,.19F,.13F}, {.31F,.15F,.11F}, {.46F,.26F,.18F}, {.24F,.12F,.09F}, {.66F,.60F,.54F}, 0.35F, 0.45F, 0.58F, .55F, 0.5F};
const Appearance kCarpet   = {{.40F,.38F,.35F}, {.28F,.27F,.27F}, {.40F,.22F,.28F}, {.22F,.32F,.16F}, {.60F,.56F,.22F}, 0.18F, 0.25F, 0.40F, .60F, 0.4F};
const Appearance kCardboard= {{.44F,.32F,.20F}, {.36F,.26F,.16F}, {.30F,.21F,.13F}, {.50F,.38F,.25F}, {.16F,.12F,.09F}, 0.40F, 0.48F, 0.55F, .50F, 0.35F};
const Appearance kWood     = {{.38F,.25F,.12F}, {.26F,.16F,.08F}, {.17F,.10F,.05F}, {.46F,.32F,.17F}, {.10F,.06F,.03F}, 0.30F, 0.42F, 0.50F, .60F, 0.3F};
const Appearance kDrum     = {{.42F,.44F,.42F}, {.34F,.36F,.36F}, {.30F,.18F,.10F}, {.50F,.50F,.46F}, {.10F,.10F,.10F}, 0.38F, 0.48F, 0.52F, .45F, 0.35F};
const Appearance kPaint    = {{.78F,.78F,.76F}, {.70F,.70F,.68F}, {.58F,.56F,.50F}, {.66F,.65F,.62F}, {.42F,.40F,.36F}, 0.45F, 0.55F, 0.60F, .30F, 0.2F};
// clang-format on

const Appearance& appearance_of(Material material) {
    switch (material) {
        case Material::Deck: return kDeck;
        case Material::Timber: return kTimber;
        case Material::Iron: return kIron;
        case Material::Sand: return kSand;
        case Material::Rock: return kRock;
        case Material::Coral: return kCoral;
        case Material::BranchCoral: return kBranch;
        case Material::Sponge: return kSponge;
        case Material::Brick: return kBrick;
        case Material::Carpet: return kCarpet;
        case Material::Cardboard: return kCardboard;
        case Material::Wood: return kWood;
        case Material::Drum: return kDrum;
        case Material::ScaleBar:
        case Material::Marker: return kPaint;
    }
    return kRock;
}

float smooth_step(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
    return t * t * (3.0F - 2.0F * t);
}

Rgb mix(const Rgb& a, const Rgb& b, float weight) { return a + weight * (b - a); }

// The octaves of the four noise channels, each faded by what the pixel resolves.
struct Octaves {
    static constexpr int kNum = 9;
    std::array<Eigen::Array4f, kNum> value;
};

Octaves octaves_at(const NoiseField& noise,
                   const Eigen::Vector3f& p,
                   float wavelength_m,
                   float footprint_m) {
    Octaves octaves;
    Eigen::Vector3f q = p / wavelength_m;
    float wavelength = wavelength_m;
    int i = 0;
    for (; i < Octaves::kNum; ++i) {
        const float weight = band_limit(wavelength, footprint_m);
        if (weight <= 0.0F) break;
        octaves.value[static_cast<std::size_t>(i)] = weight * noise.at(q);
        q = next_octave(q);
        wavelength /= kOctaveRatio;
    }
    for (; i < Octaves::kNum; ++i)
        octaves.value[static_cast<std::size_t>(i)] = Eigen::Array4f::Zero();
    return octaves;
}

Rgb natural_color(const Appearance& appearance, const Octaves& octaves) {
    const auto& o = octaves.value;
    const float tone = 0.5F + 0.5F * o[0][0] + 0.45F * o[1][0] + 0.35F * o[2][0] + 0.3F * o[3][0];
    const float patch = 0.55F * o[0][1] + 0.6F * o[1][1] + 0.45F * o[2][1] + 0.35F * o[3][1] +
                        0.25F * o[4][1] + 0.2F * o[5][1];
    const float blotch =
        0.55F * o[2][2] + 0.6F * o[3][2] + 0.5F * o[4][2] + 0.35F * o[5][2] + 0.25F * o[6][2];
    const float fleck = 0.55F * o[4][3] + 0.65F * o[5][3] + 0.6F * o[6][3] + 0.5F * o[7][3];
    const float pits = 0.6F * o[4][0] + 0.7F * o[5][0] + 0.5F * o[6][0];
    const float grain = 0.5F * o[5][1] + 0.6F * o[6][1] + 0.6F * o[7][1] + 0.5F * o[8][1];
    Rgb color = mix(appearance.tone_a, appearance.tone_b, std::clamp(tone, 0.0F, 1.0F));
    color = mix(color,
                appearance.patch,
                0.8F * smooth_step(appearance.patch_level, appearance.patch_level + 0.14F, patch));
    color =
        mix(color,
            appearance.blotch,
            0.85F * smooth_step(appearance.blotch_level, appearance.blotch_level + 0.1F, blotch));
    color = mix(color,
                appearance.fleck,
                0.6F * smooth_step(appearance.fleck_level, appearance.fleck_level + 0.15F, fleck));
    color *= 1.0F - 0.45F * smooth_step(0.42F, 0.62F, pits);
    return (color * (1.0F + 0.7F * appearance.grain * grain)).max(0.01F).min(0.95F);
}

// Returns 1 inside a stripe of `width` around multiples of `period`, blurred over the footprint.
float stripe(float x, float period, float width, float footprint) {
    const float from_middle = std::abs(std::remainder(x, period));
    return 1.0F - smooth_step(0.5F * width - 0.5F * footprint,
                              0.5F * width + 0.5F * footprint,
                              from_middle);
}

// Draws courses of 0.22 x 0.075 m, every other one shifted by half; x along the wall, y up.
Rgb lay_bricks(const Rgb& color,
               const SceneObject& object,
               const Eigen::Vector3f& p,
               float footprint_m) {
    constexpr float kLength_m = 0.22F;
    constexpr float kHeight_m = 0.075F;
    const float course = std::floor(p.y() / kHeight_m);
    const float shift = std::fmod(std::abs(course), 2.0F) * 0.5F * kLength_m;
    const float number = std::floor((p.x() + shift) / kLength_m);
    const std::uint64_t brick = base::hash64(
        object.seed, static_cast<std::int64_t>(course), static_cast<std::int64_t>(number));
    const auto tone = static_cast<float>(0.7 + 0.6 * base::to_unit(brick));
    const float joint = std::max(stripe(p.y(), kHeight_m, 0.012F, footprint_m),
                                 stripe(p.x() + shift, kLength_m, 0.012F, footprint_m));
    return mix(tone * color, 1.1F * color + Rgb(0.22F, 0.22F, 0.2F), joint);
}

// Draws printed bars and tape on parcels and drums, one in most cells of 9 cm.
Rgb print_labels(const Rgb& color,
                 const SceneObject& object,
                 const Eigen::Vector3f& p,
                 float footprint_m) {
    constexpr float kCell_m = 0.09F;
    const Eigen::Array3f cell = (p.array() / kCell_m).floor();
    const std::uint64_t hash = base::hash64(object.seed,
                                            static_cast<std::int64_t>(cell.x()),
                                            static_cast<std::int64_t>(cell.y()),
                                            static_cast<std::int64_t>(cell.z()));
    if (hash % 5 > 2) return color;
    const Eigen::Array3f inside = p.array() / kCell_m - cell - 0.5F;  // -0.5 to 0.5
    Eigen::Array3f half;
    for (int axis = 0; axis < 3; ++axis)
        half[axis] = static_cast<float>(0.06 + 0.3 * base::to_unit(base::hash64(hash, axis)));
    const float soft = 0.5F * footprint_m / kCell_m + 1e-3F;
    const Eigen::Array3f depth = half - inside.abs();
    const std::array<float, 3> in = {smooth_step(-soft, soft, depth.x()),
                                     smooth_step(-soft, soft, depth.y()),
                                     smooth_step(-soft, soft, depth.z())};
    const float covered = in[0] * in[1] * in[2];
    static const std::array<Rgb, 4> kInks = {Rgb(0.05F, 0.05F, 0.06F),
                                             Rgb(0.45F, 0.06F, 0.05F),
                                             Rgb(0.06F, 0.10F, 0.38F),
                                             Rgb(0.75F, 0.73F, 0.68F)};
    return mix(color, kInks[(hash >> 8) % kInks.size()], 0.85F * covered);
}

Rgb paint_segments(const Rgb& color, const SceneObject& object, float x, float footprint_m) {
    const float from_end = x + 0.5F * object.length_m;
    // Black near the centre of the first half of each 0.2 m period.
    const float black = stripe(from_end - 0.05F, 0.2F, 0.1F, footprint_m);
    return mix(color, Rgb(0.03F, 0.03F, 0.03F) + 0.1F * color, black);
}

// Returns the share of the footprint of `x` that cell `i` covers along an axis.
float covered(int i, float x, float half_m, float cell_m) {
    const float low = std::max(static_cast<float>(i) * cell_m, x - half_m);
    const float high = std::min(static_cast<float>(i + 1) * cell_m, x + half_m);
    return std::max(0.0F, high - low) / (2.0F * half_m);
}

// Draws the tag, averaged over the footprint, with white paper around it.
Rgb print_tag(const SceneObject& object, const Eigen::Vector3f& p, float footprint_m) {
    const float half_m = std::max(0.5F * footprint_m, 1e-5F);
    const int num_cells = object.tag.cols;
    const float x = p.x() + 0.5F * static_cast<float>(num_cells) * object.cell_m;
    // Rows count downwards.
    const float y = 0.5F * static_cast<float>(num_cells) * object.cell_m - p.y();
    float black = 0.0F;
    for (int row = 0; row < num_cells; ++row) {
        const float down = covered(row, y, half_m, object.cell_m);
        if (down <= 0.0F) continue;
        for (int column = 0; column < num_cells; ++column)
            if (object.tag.at<std::uint8_t>(row, column) == 0)
                black += down * covered(column, x, half_m, object.cell_m);
    }
    return mix(Rgb::Constant(0.72F), Rgb::Constant(0.03F), black);
}

}  // namespace

NoiseField texture_noise(std::uint64_t seed) {
    return NoiseField(base::hash64(seed, 0x74657874ULL));
}

Rgb surface_color(const SceneObject& object,
                  const NoiseField& noise,
                  const Eigen::Vector3f& p_world,
                  const Eigen::Vector3f& normal_world,
                  float footprint_m) {
    const Appearance& appearance = appearance_of(object.material);
    const Eigen::Vector3f p = object.T_object_world * p_world;
    if (object.material == Material::Marker) return print_tag(object, p, footprint_m);
    const Eigen::Vector3f shift(static_cast<float>(object.seed % 97),
                                static_cast<float>(object.seed / 97 % 89),
                                static_cast<float>(object.seed / 9973 % 83));
    Eigen::Vector3f grained = p;
    if (object.material == Material::Wood || object.material == Material::Timber)
        grained.x() *= 0.45F;  // fibres run along x
    Rgb color = natural_color(
        appearance, octaves_at(noise, grained + shift, appearance.wavelength_m, footprint_m));
    switch (object.material) {
        case Material::Brick: color = lay_bricks(color, object, p, footprint_m); break;
        case Material::Drum:
        case Material::Cardboard: color = print_labels(color, object, p, footprint_m); break;
        case Material::ScaleBar: color = paint_segments(color, object, p.x(), footprint_m); break;
        case Material::Coral:
        case Material::BranchCoral:
        case Material::Sponge: {
            const auto hue = static_cast<float>(base::to_unit(base::hash64(object.seed, 5)));
            color *= mix(Rgb(1.15F, 0.9F, 0.75F), Rgb(0.8F, 0.95F, 1.25F), hue);
            break;
        }
        default: break;
    }
    // Silt settles on surfaces that face up.
    const float silt = 0.12F * std::max(0.0F, normal_world.z());
    return mix(color, 1.2F * color + Rgb(0.02F, 0.02F, 0.015F), silt);
}

}  // namespace divemesh::simulator
