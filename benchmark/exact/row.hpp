// What both computations share: how a row is read, what is noted of it, and how results are written.
#pragma once
#include <quadmath.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

using Q = __float128;
using List = std::vector<Q>;

enum Law { elastic, kelvinVoigt, kelvinVoigtNoPull, huntCrossley, viscoelastic };

struct Row {
    int n;
    Q p, damping, pull, stop;  // exponent, coefficient of the law, g/L (1/s2), end (s); 0: when all have parted
    Law law;
    List m, x, v, k, gap;
    // Scales: a mass, the largest speed and overlap, the time of a contact.
    Q mass, speed, overlap, time;
};

inline Q number() {
    std::string word;
    if (!(std::cin >> word)) throw std::string("the row ends early");
    return strtod(word.c_str(), nullptr);  // doubles in hexadecimal digits: exact
}

// Reads a row; with a seed, each of its values is changed by 1e-16 of itself, up or down by chance.
inline Row read(unsigned seed) {
    auto changed = [seed](Q value) mutable {
        if (!seed) return value;
        for (int i = 0; i < 3; i++) seed = seed * 1664525u + 1013904223u;
        return value * (1 + (seed >> 31 ? 1e-16Q : -1e-16Q));
    };
    Row row;
    row.n = int(number()), row.law = Law(int(number()));
    row.p = number(), row.damping = changed(number()), row.pull = changed(number()), row.stop = number();
    for (List* list : {&row.m, &row.x, &row.v, &row.k, &row.gap})
        for (int i = 0; i < row.n - (list == &row.k || list == &row.gap); i++) list->push_back(changed(number()));
    Q first = 0, stiff = *std::max_element(row.k.begin(), row.k.end());
    for (Q v : row.v) first = std::max(first, fabsq(v));
    for (Q x : row.x) first = std::max(first, sqrtq(row.pull) * fabsq(x));
    row.mass = *std::max_element(row.m.begin(), row.m.end()), row.speed = first;
    row.overlap = powq(row.mass * first * first / stiff, 1 / (row.p + 1)), row.time = row.overlap / first;
    return row;
}

inline Q energy(const Row& row, const List& x, const List& v) {
    Q sum = 0;
    for (int i = 0; i < row.n; i++) sum += row.m[i] * (v[i] * v[i] + row.pull * x[i] * x[i]) / 2;
    return sum;
}

// Whether nothing more is to be expected of a contact: slower approaches are rounding, and far behind a pulse contacts
// stay closed for ages by overlaps that transmit nothing.
inline bool rests(const Row& row, int j, bool open, Q overlap, Q rate) {
    const Q least = 1e-20Q;
    if (open) return rate < least * row.speed;
    Q impulse = row.k[j] * powq(fabsq(overlap), row.p) * row.time;
    return fabsq(rate) < least * row.speed && impulse < least * row.mass * row.speed;
}

struct Notes {
    List peak, onset, release;
    std::vector<std::pair<Q, int>> onsets;
    explicit Notes(int n) : peak(n - 1), onset(n - 1, -1), release(n - 1, -1) {}
    void opens(int j, Q t) { release[j] = t; }
    void closes(int j, Q t) {
        if (onset[j] < 0) onset[j] = t;
        onsets.emplace_back(t, j + 1);
    }
    void force(int j, Q f) { peak[j] = std::max(peak[j], f); }
};

inline void show(const char* name, const List& list) {
    printf("%s", name);
    for (Q value : list) {
        char text[64];
        quadmath_snprintf(text, sizeof text, "%.26Qe", value);
        printf(" %s", text);
    }
    printf("\n");
}

inline void write(const Row& row, const Notes& notes, const List& x, const List& v) {
    show("x", x), show("v", v), show("peak", notes.peak), show("onset", notes.onset), show("release", notes.release);
    show("loss", {energy(row, row.x, row.v) - energy(row, x, v)});
    List times, contacts;
    for (auto& [t, j] : notes.onsets) times.push_back(t), contacts.push_back(j);
    show("times", times), show("contacts", contacts);
}

template <class Run> int start(int count, char** words) {
    try {
        Run(read(count > 1 ? unsigned(atoi(words[1])) : 0)).go();
        return 0;
    } catch (const std::string& problem) {
        fprintf(stderr, "%s\n", problem.c_str());
        return 1;
    }
}
