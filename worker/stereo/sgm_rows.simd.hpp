// The loops of semi-global matching over vectors of bytes. Included once per instruction set by
// sgm_kernels.cpp, after the types and operations of that set: no include guard.

void census(const std::uint8_t* center,
            const std::uint8_t* const* neighbours,
            int num,
            int tolerance,
            std::uint8_t* plane) {
    const int first_rest = num >= kBytes ? num : 0;
    for (int start = 0; start < first_rest; start += kBytes) {
        const int x = std::min(start, num - kBytes);  // the last vector overlaps the one before
        const V c = load(center + x);
        const V limits[2] = {add_saturated(c, broadcast(tolerance)),
                             subtract(c, min(c, broadcast(tolerance)))};
        V bits = broadcast(0);
        for (int k = 0; k < 8; ++k) {
            const V limit = limits[k & 1];
            bits = add(bits,
                       broadcast_where_equal(min(load(neighbours[k] + x), limit), limit, 1 << k));
        }
        store(plane + x, bits);
    }
    for (int x = first_rest; x < num; ++x) {
        int bits = 0;
        for (int k = 0; k < 8; ++k) {
            const int limit = (k & 1) != 0 ? std::max(0, center[x] - tolerance)
                                           : std::min(255, center[x] + tolerance);
            bits |= (neighbours[k][x] >= limit ? 1 : 0) << k;
        }
        plane[x] = static_cast<std::uint8_t>(bits);
    }
}

// Computes P2 from the difference of two grey values: a large difference may be an edge of the
// scene.
void penalties(const std::uint8_t* __restrict a,
               const std::uint8_t* __restrict b,
               int num,
               std::uint8_t* __restrict penalty) {
    constexpr int kHalving = 12;  // a difference in grey values that halves P2
    for (int x = 0; x < num; ++x) {
        const int step = a[x] > b[x] ? a[x] - b[x] : b[x] - a[x];
        const float lowered =
            static_cast<float>(kMaxStepPenalty * kHalving) / static_cast<float>(kHalving + step);
        const int whole = static_cast<int>(lowered);
        penalty[x] = static_cast<std::uint8_t>(whole > kMinStepPenalty ? whole : kMinStepPenalty);
    }
}

// The cost behind the last disparity, where the vectors are longer: too large to be chosen from any
// path, and small enough for a byte.
constexpr int kBehindRange = 120;
static_assert(kNumCensusBits + kMaxStepPenalty < kBehindRange);
static_assert(kBehindRange + kMaxStepPenalty <= kOutsideCost);

DIVEMESH_INLINE_BODY int stride_of(int num_disparities) {
    return (num_disparities + kBytes - 1) / kBytes * kBytes;
}

struct Step {
    V min_cost;
    V far;
    // Costs of the previous pixel at the previous, the current and the next vector of disparities.
    V before;
    V here;
    V after;
};

// L(p, d) = C(p, d) + min(L(q, d), L(q, d +- 1) + P1, min L(q) + P2) - min L(q); eq. 14 of
// Hirschmueller 2008.
DIVEMESH_INLINE_BODY V path_cost(const Step& step, V cost) {
    const V near = add(min(one_lower(step.before, step.here), one_upper(step.here, step.after)),
                       broadcast(kSmallStepPenalty));
    return add(subtract(min(min(step.here, near), step.far), step.min_cost), cost);
}

// Does the next step of a path; its costs replace those of the previous pixel.
DIVEMESH_INLINE_BODY V take_step(Step& step, std::uint8_t* costs, int d, int stride, V cost) {
    step.after = d + kBytes < stride ? load(costs + d + kBytes) : broadcast(kOutsideCost);
    const V next = path_cost(step, cost);
    store(costs + d, next);
    step.before = step.here;
    step.here = step.after;
    return next;
}

DIVEMESH_INLINE_BODY Step first_step(const std::uint8_t* costs, V min_cost, int penalty) {
    Step step;
    step.min_cost = min_cost;
    step.far = add(min_cost, broadcast(penalty));
    step.before = broadcast(kOutsideCost);
    step.here = load(costs);
    return step;
}

// The state of one row's sweep from left to right.
struct Sweep {
    const ForwardRow* row = nullptr;
    int slots[3] = {};
    V left_min;
    alignas(kMaxVectorBytes) std::uint8_t from_left[kMaxDisparities];
};

template <bool kClipped>
DIVEMESH_INLINE_BODY void forward_pixel(Sweep& sweep, int x, int num_vectors) {
    const ForwardRow& row = *sweep.row;
    const int stride = num_vectors * kBytes;
    const int num_in_image = row.first_x + x + 1 - row.first_disparity;
    const std::ptrdiff_t reversed = row.width - 1 - x;
    const std::uint8_t* right[4];
    V left[4];
    for (int p = 0; p < 4; ++p) {
        left[p] = broadcast(row.left[p][x]);
        right[p] = row.right_reversed[p] + reversed;
    }
    std::uint8_t* paths[4];
    Step step[4];
    V min_costs[4];
    for (int p = 0; p < 4; ++p) {
        paths[p] = p == 3
                       ? sweep.from_left
                       : row.above[p].costs + static_cast<std::ptrdiff_t>(sweep.slots[p]) * stride;
        step[p] =
            first_step(paths[p],
                       p == 3 ? sweep.left_min : broadcast(row.above[p].min_cost[sweep.slots[p]]),
                       row.penalty[p][x]);
        min_costs[p] = broadcast(255);
    }
    std::uint8_t* cost = row.cost + static_cast<std::ptrdiff_t>(x) * stride;
    std::uint8_t* sum = row.sum + static_cast<std::ptrdiff_t>(x) * stride;
    for (int i = 0; i < num_vectors; ++i) {
        const int d = i * kBytes;
        V c = hamming(left, right, d);
        if constexpr (kClipped) c = first_or(c, num_in_image - d, kNumCensusBits);
        if (kBytes > 32 && d + kBytes > row.num_disparities)
            c = first_or(c, row.num_disparities - d, kBehindRange);
        store(cost + d, c);
        V costs[4];
        for (int p = 0; p < 4; ++p) {
            costs[p] = take_step(step[p], paths[p], d, stride, c);
            min_costs[p] = min(min_costs[p], costs[p]);
        }
        store(sum + d,
              add_saturated(add_saturated(costs[0], costs[1]), add_saturated(costs[2], costs[3])));
    }
    const PathMinima minima = path_minima(min_costs);
    row.above[0].min_cost[sweep.slots[0]] = min_of_path<0>(minima);
    row.above[1].min_cost[sweep.slots[1]] = min_of_path<1>(minima);
    row.above[2].min_cost[sweep.slots[2]] = min_of_path<2>(minima);
    sweep.left_min = broadcast_last(minima);
}

DIVEMESH_INLINE_BODY void advance(Sweep& sweep, int x, int num_vectors) {
    const ForwardRow& row = *sweep.row;
    if (row.first_x + x + 1 - row.first_disparity < row.num_disparities)
        forward_pixel<true>(sweep, x, num_vectors);
    else
        forward_pixel<false>(sweep, x, num_vectors);
    for (int& slot : sweep.slots) slot = slot == row.width ? 0 : slot + 1;
}

// The step from left to right waits for the previous pixel, so two rows are processed together. The
// second lags behind, so that it finds the row above done.
DIVEMESH_INLINE_BODY void forward_body(const ForwardRow* rows, int num_rows, int num_vectors) {
    constexpr int kLag = 2;
    Sweep sweeps[2];
    for (int r = 0; r < num_rows; ++r) {
        sweeps[r].row = &rows[r];
        sweeps[r].left_min = broadcast(0);
        for (int i = 0; i < num_vectors; ++i) {
            const int d = i * kBytes;
            store(sweeps[r].from_left + d,
                  first_or(broadcast(0), rows[r].num_disparities - d, kOutsideCost));
        }
        for (int p = 0; p < 3; ++p) sweeps[r].slots[p] = rows[r].above[p].first_slot;
    }
    const int width = rows[0].width;
    if (num_rows == 1) {
        for (int x = 0; x < width; ++x) advance(sweeps[0], x, num_vectors);
        return;
    }
    for (int x = 0; x < kLag; ++x) advance(sweeps[0], x, num_vectors);
    for (int x = kLag; x < width; ++x) {
        advance(sweeps[0], x, num_vectors);
        advance(sweeps[1], x - kLag, num_vectors);
    }
    for (int x = width - kLag; x < width; ++x) advance(sweeps[1], x, num_vectors);
}

// Returns the first index of `best`, the min of the sums.
DIVEMESH_INLINE_BODY int find_first(const std::uint8_t* sums, int num_vectors, int best) {
    const V best_v = broadcast(best);
    int first = 0;
    for (int i = num_vectors - 1; i >= 0; --i) {
        const int d = i * kBytes;
        const std::uint64_t equal = where_equal(load(sums + d), best_v);
        first = equal != 0 ? d + __builtin_ctzll(equal) : first;
    }
    return first;
}

// Returns true if only the winner's neighbours have sums close to it.
DIVEMESH_INLINE_BODY bool is_unique(const std::uint8_t* sums,
                                    int num,
                                    int num_vectors,
                                    int winner) {
    const int best = sums[winner];
    const int limit = std::min(255, best * 100 / (100 - kUniqueness_percent));
    int num_near = 0;
    for (int i = 0; i < num_vectors; ++i) {
        const int d = i * kBytes;
        num_near += num_at_most(load(sums + d), broadcast(limit), num - d);
    }
    const int num_own =
        1 + (sums[winner - 1] <= limit ? 1 : 0) + (sums[winner + 1] <= limit ? 1 : 0);
    return (best < 255) & (winner > 0) & (winner < num - 1) & (num_near == num_own);
}

// The state of one row's sweep from right to left.
struct BackwardSweep {
    const BackwardRow* row = nullptr;
    V min_cost;
    alignas(kMaxVectorBytes) std::uint8_t from_right[kMaxDisparities];
    // The sums of the last pixel, between margins.
    alignas(kMaxVectorBytes) std::uint8_t sums[kMaxDisparities + 2 * kMaxVectorBytes] = {};
};

DIVEMESH_INLINE_BODY void backward_pixel(BackwardSweep& sweep, int x, int num_vectors) {
    const BackwardRow& row = *sweep.row;
    const int stride = num_vectors * kBytes;
    Step step = first_step(sweep.from_right, sweep.min_cost, row.penalty[x]);
    const std::uint8_t* cost = row.cost + static_cast<std::ptrdiff_t>(x) * stride;
    const std::uint8_t* sum = row.sum + static_cast<std::ptrdiff_t>(x) * stride;
    std::uint8_t* sums = sweep.sums + kMaxVectorBytes;
    V min_cost = broadcast(255);
    V best = broadcast(255);
    for (int i = 0; i < num_vectors; ++i) {
        const int d = i * kBytes;
        const V c = take_step(step, sweep.from_right, d, stride, load(cost + d));
        const V s = add_saturated(load(sum + d), c);
        store(sums + d, s);
        min_cost = min(min_cost, c);
        best = min(best, s);
    }
    const PathMinima minima = path_minima({best, min_cost, best, min_cost});
    sweep.min_cost = broadcast_last(minima);
    row.min_cost[x] = min_of_path<0>(minima);
    const int winner = find_first(sums, num_vectors, row.min_cost[x]);
    row.min_at[x] = static_cast<std::int16_t>(winner);
    row.is_unique[x] = is_unique(sums, row.num_disparities, num_vectors, winner) ? 1 : 0;
    row.lower[x] = sums[winner - 1];
    row.upper[x] = sums[winner + 1];
}

DIVEMESH_INLINE_BODY void backward_body(const BackwardRow* rows, int num_rows, int num_vectors) {
    BackwardSweep sweeps[2];
    for (int r = 0; r < num_rows; ++r) {
        sweeps[r].row = &rows[r];
        sweeps[r].min_cost = broadcast(0);
        for (int i = 0; i < num_vectors; ++i) {
            const int d = i * kBytes;
            store(sweeps[r].from_right + d,
                  first_or(broadcast(0), rows[r].num_disparities - d, kOutsideCost));
        }
    }
    if (num_rows == 1) {
        for (int x = rows[0].width - 1; x >= 0; --x) backward_pixel(sweeps[0], x, num_vectors);
        return;
    }
    for (int x = rows[0].width - 1; x >= 0; --x) {
        backward_pixel(sweeps[0], x, num_vectors);
        backward_pixel(sweeps[1], x, num_vectors);
    }
}

// Interpolates between whole disparities by two lines, the shape of an absolute-difference cost.
void place(const WinnerRow& row, float* __restrict disparity_px) {
    const std::int16_t* __restrict min_at = row.min_at;
    const std::uint8_t* __restrict min_cost = row.min_cost;
    const std::uint8_t* __restrict lower = row.lower;
    const std::uint8_t* __restrict upper = row.upper;
    const std::uint8_t* __restrict is_confirmed = row.is_confirmed;
    for (int x = 0; x < row.width; ++x) {
        const int d = min_at[x];
        const int larger = lower[x] > upper[x] ? lower[x] : upper[x];
        const int slope = larger - min_cost[x];
        const auto whole = static_cast<float>(d);
        const float between = whole + 0.5F * static_cast<float>(lower[x] - upper[x]) /
                                          static_cast<float>(slope > 0 ? slope : 1);
        const float known = is_confirmed[x] != 0 ? between : -whole;
        disparity_px[x] = d < x ? known : 0.0F;
    }
}

// Small numbers of vectors are passed as compile-time constants.
void forward(const ForwardRow* rows, int num_rows) {
    switch (const int num_vectors = stride_of(rows[0].num_disparities) / kBytes; num_vectors) {
        case 1: return forward_body(rows, num_rows, 1);
        case 2: return forward_body(rows, num_rows, 2);
        case 3: return forward_body(rows, num_rows, 3);
        case 4: return forward_body(rows, num_rows, 4);
        default: return forward_body(rows, num_rows, num_vectors);
    }
}

void backward(const BackwardRow* rows, int num_rows) {
    switch (const int num_vectors = stride_of(rows[0].num_disparities) / kBytes; num_vectors) {
        case 1: return backward_body(rows, num_rows, 1);
        case 2: return backward_body(rows, num_rows, 2);
        case 3: return backward_body(rows, num_rows, 3);
        case 4: return backward_body(rows, num_rows, 4);
        default: return backward_body(rows, num_rows, num_vectors);
    }
}

SgmKernels kernels() { return {forward, backward, place, census, penalties, kBytes}; }
