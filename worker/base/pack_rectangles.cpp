#include "worker/base/pack_rectangles.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "schemas/error.hpp"

#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#include <stb/stb_rect_pack.h>

namespace divemesh::base {
namespace {

void check(const cv::Size& size, int max_side_px) {
    if (size.empty() || std::max(size.width, size.height) > max_side_px)
        throw Error(ErrorCode::InvalidArgument,
                    "a rectangle of " + std::to_string(size.width) + " x " +
                        std::to_string(size.height) + " px is to be packed: give 1 to " +
                        std::to_string(max_side_px) + " px a side");
}

// Returns the width of a sheet that is about square with all the rectangles on it.
int sheet_width_px(const std::vector<stbrp_rect>& rectangles, int max_side_px) {
    constexpr double kRoom = 1.05;  // for what remains empty
    double area = 0.0;
    int widest_px = 1;
    for (const stbrp_rect& rectangle : rectangles) {
        area += static_cast<double>(rectangle.w) * rectangle.h;
        widest_px = std::max(widest_px, rectangle.w);
    }
    return std::min(max_side_px,
                    std::max(widest_px, static_cast<int>(std::ceil(std::sqrt(kRoom * area)))));
}

// Packs what fits onto one more sheet, and removes it from `rectangles`.
void pack_one(std::vector<stbrp_rect>& rectangles, int max_side_px, RectanglePacking& packing) {
    const int width_px = sheet_width_px(rectangles, max_side_px);
    std::vector<stbrp_node> nodes(static_cast<std::size_t>(width_px));
    stbrp_context context;
    stbrp_init_target(&context, width_px, max_side_px, nodes.data(), width_px);
    stbrp_pack_rects(&context, rectangles.data(), static_cast<int>(rectangles.size()));
    cv::Rect used;
    for (const stbrp_rect& rectangle : rectangles) {
        if (rectangle.was_packed == 0) continue;
        packing.sheet_of[rectangle.id] = static_cast<std::int32_t>(packing.sheets.size());
        packing.corners[rectangle.id] = {rectangle.x, rectangle.y};
        used |= cv::Rect(rectangle.x, rectangle.y, rectangle.w, rectangle.h);
    }
    packing.sheets.push_back(used.size());
    std::erase_if(rectangles,
                  [](const stbrp_rect& rectangle) { return rectangle.was_packed != 0; });
}

}  // namespace

RectanglePacking pack_rectangles(const std::vector<cv::Size>& rectangles, int max_side_px) {
    RectanglePacking packing;
    packing.sheet_of.resize(rectangles.size());
    packing.corners.resize(rectangles.size());
    std::vector<stbrp_rect> left(rectangles.size());
    for (std::size_t i = 0; i < rectangles.size(); ++i) {
        check(rectangles[i], max_side_px);
        left[i].id = static_cast<int>(i);
        left[i].w = rectangles[i].width;
        left[i].h = rectangles[i].height;
    }
    while (!left.empty()) pack_one(left, max_side_px, packing);
    return packing;
}

}  // namespace divemesh::base
