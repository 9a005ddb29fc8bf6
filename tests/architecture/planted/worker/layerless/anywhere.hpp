#pragma once

struct Anywhere {
    int value = 0;
};
