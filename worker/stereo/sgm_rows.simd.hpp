// The loops of semi-global matching over vectors of bytes. Included once per instruction set by
// sgm_kernels.cpp, after the types and operations of that set: no include guard.

void census(const std::uint8_t* center,
            const std::uint8_t* const* neighbours,
            int num,
            std::uint8_t* plane) {
    const int first_rest = num >= kBytes ? num : 0;
    for (int start = 0; start < first_rest; start += kBytes) {
        const int x = std::min(start, num - kBytes);  // the last vector overlaps the one before
        const V c = load(center + x);
        V bits = splat(0);
        for (int k = 0; k < 8; ++k)
            bits = add(bits, splat_where_equal(least_of(load(neighbours[k] + x), c), c, 1 << k));
        store(plane + x, bits);
    }
    for (int x = first_rest; x < num; ++x) {
        int bits = 0;
        for (int k = 0; k < 8; ++k) bits |= (neighbours[k][x] >= center[x] ? 1 : 0) << k;
        plane[x] = static_cast<std::uint8_t>(bits);
    }
}

// P2 by the difference of two grey values: as it is told from an edge of the scene.
void penalties(const std::uint8_t* __restrict a,
               const std::uint8_t* __restrict b,
               int num,
               std::uint8_t* __restrict penalty) {
    constexpr int kHalving = 12;  // grey values that halve it
    for (int x = 0; x < num; ++x) {
        const int step = a[x] > b[x] ? a[x] - b[x] : b[x] - a[x];
        const float lowered = static_cast<float>(kLargestStepPenalty * kHalving) /
                              static_cast<float>(kHalving + step);
        const int whole = static_cast<int>(lowered);
        penalty[x] =
            static_cast<std::uint8_t>(whole > kLeastStepPenalty ? whole : kLeastStepPenalty);
    }
}

struct Step {
    V least;
    V far;
    V before;
    V lower;  // the one before, at d - 1
    V upper;
};

// L(p, d) = C(p, d) + min(L(q, d), L(q, d +- 1) + P1, min L(q) + P2) - min L(q); eq. 14 of
// Hirschmueller 2008.
DIVEMESH_INLINE_BODY V path_cost(const Step& step, V cost) {
    const V near = add(least_of(step.lower, step.upper), splat(kSmallStepPenalty));
    return add(subtract(least_of(least_of(step.before, near), step.far), step.least), cost);
}

template <bool kClipped>
DIVEMESH_INLINE_BODY void forward_pixel(const ForwardRow& row,
                                        int x,
                                        const int (&slots)[3],
                                        V& left_least) {
    const int num = row.num_disparities;
    const int stride = num + kPathMargin;
    const int num_in_image = x + 1 - row.first_disparity;
    const std::ptrdiff_t reversed = row.width - 1 - x;
    const std::uint8_t* right[4];
    V left[4];
    for (int p = 0; p < 4; ++p) {
        left[p] = splat(row.left[p][x]);
        right[p] = row.right_reversed[p] + reversed;
    }
    std::uint8_t* above[3];
    Step step[4];
    V least[4];
    for (int p = 0; p < 3; ++p) {
        above[p] = row.above[p].costs + static_cast<std::ptrdiff_t>(slots[p]) * stride;
        step[p].least = splat(row.above[p].least[slots[p]]);
        step[p].lower = load(above[p] - 1);
    }
    step[3].least = left_least;
    for (int p = 0; p < 4; ++p) {
        step[p].far = add(step[p].least, splat(row.penalty[p][x]));
        least[p] = splat(255);
    }
    const std::uint8_t* before = row.from_left + (x & 1) * stride + kPathMargin;
    std::uint8_t* here = row.from_left + ((x + 1) & 1) * stride + kPathMargin;
    std::uint8_t* cost = row.cost + static_cast<std::ptrdiff_t>(x) * num;
    std::uint8_t* sum = row.sum + static_cast<std::ptrdiff_t>(x) * num;
    for (int d = 0; d < num; d += kBytes) {
        V c = hamming(left, right, d);
        if constexpr (kClipped) c = first_or(c, num_in_image - d, kNumCensusBits);
        store(cost + d, c);
        V costs[4];
        for (int p = 0; p < 3; ++p) {
            step[p].before = load(above[p] + d);
            step[p].upper = load(above[p] + d + 1);
            const V next_lower = load(above[p] + d + kBytes - 1);  // before it is overwritten
            costs[p] = path_cost(step[p], c);
            step[p].lower = next_lower;
            store(above[p] + d, costs[p]);
        }
        step[3].before = load(before + d);
        step[3].lower = load(before + d - 1);
        step[3].upper = load(before + d + 1);
        costs[3] = path_cost(step[3], c);
        store(here + d, costs[3]);
        for (int p = 0; p < 4; ++p) least[p] = least_of(least[p], costs[p]);
        store(sum + d,
              add_saturated(add_saturated(costs[0], costs[1]), add_saturated(costs[2], costs[3])));
    }
    for (int p = 0; p < 3; ++p)
        row.above[p].least[slots[p]] = static_cast<std::uint8_t>(least_byte(least[p]));
    left_least = splat(least_byte(least[3]));
}

// One row on its way from left to right.
struct Sweep {
    const ForwardRow* row = nullptr;
    int slots[3] = {};
    V left_least;
};

DIVEMESH_INLINE_BODY void advance(Sweep& sweep, int x) {
    const ForwardRow& row = *sweep.row;
    if (x + 1 - row.first_disparity < row.num_disparities)
        forward_pixel<true>(row, x, sweep.slots, sweep.left_least);
    else
        forward_pixel<false>(row, x, sweep.slots, sweep.left_least);
    for (int& slot : sweep.slots) slot = slot == row.width ? 0 : slot + 1;
}

// The step from left to right waits for the pixel before it, so a second row goes along, far enough
// behind to find the row above done.
void forward(const ForwardRow* rows, int num_rows) {
    constexpr int kLag = 2;
    Sweep sweeps[2];
    for (int r = 0; r < num_rows; ++r) {
        sweeps[r].row = &rows[r];
        sweeps[r].left_least = splat(0);
        for (int p = 0; p < 3; ++p) sweeps[r].slots[p] = rows[r].above[p].first_slot;
    }
    const int width = rows[0].width;
    if (num_rows == 1) {
        for (int x = 0; x < width; ++x) advance(sweeps[0], x);
        return;
    }
    for (int x = 0; x < kLag; ++x) advance(sweeps[0], x);
    for (int x = kLag; x < width; ++x) {
        advance(sweeps[0], x);
        advance(sweeps[1], x - kLag);
    }
    for (int x = width - kLag; x < width; ++x) advance(sweeps[1], x);
}

struct Winner {
    int d;
    std::uint8_t is_unique;
};

// The first place of `best` in sums[0, num), and whether anything but its neighbours comes near it.
DIVEMESH_INLINE_BODY Winner find_winner(const std::uint8_t* sums, int num, int best) {
    constexpr int kMostWords = kMostDisparities / 64;
    std::uint64_t equal[kMostWords + 1] = {};
    std::uint64_t near[kMostWords + 1] = {};
    const V best_v = splat(best);
    const V limit = splat(std::min(255, best * 100 / (100 - kUniqueness_percent)));
    for (int d = 0; d < num; d += kBytes) {
        const V s = load(sums + d);
        equal[d / 64] |= where_equal(s, best_v) << (d % 64);
        near[d / 64] |= where_equal(least_of(s, limit), s) << (d % 64);
    }
    int winner = 0;
    for (int i = (num - 1) / 64; i >= 0; --i)
        winner = equal[i] != 0 ? 64 * i + __builtin_ctzll(equal[i]) : winner;
    if (best == 255) return {winner, 0};
    const int first = std::max(0, winner - 1);
    const std::uint64_t neighbours = winner == 0 ? 3 : 7;
    near[first / 64] &= ~(neighbours << (first % 64));
    near[first / 64 + 1] &= ~(neighbours >> 1 >> (63 - first % 64));
    std::uint64_t any = 0;
    for (int i = 0; i <= (num - 1) / 64; ++i) any |= near[i];
    const bool at_end = winner == 0 || winner == num - 1;
    return {winner, static_cast<std::uint8_t>(any == 0 && !at_end)};
}

// One row on its way from right to left.
struct Return {
    const BackwardRow* row = nullptr;
    V least;
    // What the last pixel's disparities sum up to, between margins.
    alignas(kWidestVector) std::uint8_t sums[kMostDisparities + 2 * kWidestVector];
};

DIVEMESH_INLINE_BODY void retreat(Return& sweep, int x) {
    const BackwardRow& row = *sweep.row;
    const int num = row.num_disparities;
    const int stride = num + kPathMargin;
    Step step;
    step.least = sweep.least;
    step.far = add(step.least, splat(row.penalty[x]));
    const std::uint8_t* cost = row.cost + static_cast<std::ptrdiff_t>(x) * num;
    const std::uint8_t* sum = row.sum + static_cast<std::ptrdiff_t>(x) * num;
    const std::uint8_t* before = row.from_right + (x & 1) * stride + kPathMargin;
    std::uint8_t* here = row.from_right + ((x + 1) & 1) * stride + kPathMargin;
    std::uint8_t* sums = sweep.sums + kWidestVector;
    V least = splat(255);
    V best = splat(255);
    for (int d = 0; d < num; d += kBytes) {
        step.before = load(before + d);
        step.lower = load(before + d - 1);
        step.upper = load(before + d + 1);
        const V c = path_cost(step, load(cost + d));
        const V s = add_saturated(load(sum + d), c);
        store(here + d, c);
        store(sums + d, s);
        least = least_of(least, c);
        best = least_of(best, s);
    }
    sweep.least = splat(least_byte(least));
    const int lowest = least_byte(best);
    const Winner winner = find_winner(sums, num, lowest);
    row.least[x] = static_cast<std::uint8_t>(lowest);
    row.least_at[x] = static_cast<std::int16_t>(winner.d);
    row.is_unique[x] = winner.is_unique;
    std::memcpy(row.around + 3 * x, sums + winner.d - 1, 3);
}

void backward(const BackwardRow* rows, int num_rows) {
    Return sweeps[2];
    for (int r = 0; r < num_rows; ++r) {
        sweeps[r].row = &rows[r];
        sweeps[r].least = splat(0);
    }
    if (num_rows == 1) {
        for (int x = rows[0].width - 1; x >= 0; --x) retreat(sweeps[0], x);
        return;
    }
    for (int x = rows[0].width - 1; x >= 0; --x) {
        retreat(sweeps[0], x);
        retreat(sweeps[1], x);
    }
}
