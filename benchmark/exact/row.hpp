// What both computations share: how a row is read, its motion and what is noted of it, how results are written.
#pragma once
#include <quadmath.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <utility>
#include <vector>

using Q = __float128;
using List = std::vector<Q>;

enum Law { elastic, kelvinVoigt, kelvinVoigtNoPull, huntCrossley, viscoelastic };

inline Q number() {
    double value;  // in hexadecimal digits: exact
    if (scanf("%lf", &value) != 1) throw std::runtime_error("the row ends early");
    return value;
}

inline void show(const char* name, const List& list) {
    char text[64];
    printf("%s", name);
    for (Q value : list) quadmath_snprintf(text, sizeof text, "%.26Qe", value), printf(" %s", text);
    printf("\n");
}

// A row and its motion, from the program's standard input; its argument is the seed.
struct Motion {
    int n;
    Q p, damping, pull, stop;  // exponent, coefficient of the law, g/L (1/s2), end (s); 0: when all have parted
    Law law;
    List m, k, gap, y;
    Q mass, speed, overlap, time;  // scales: a mass, the largest speed and overlap, the time of a contact
    Q t = 0, initial;              // s; the energy at the start, J
    Q *x, *v, *d, *w;              // in y: of balls, and overlaps and their rates
    std::vector<char> mode;        // of contacts; 0: open
    List peak, onset, release, onsets, contacts;

    // The row is apart or in touch. With a seed but 0, each value is changed by 1e-16 of itself, up or down by chance.
    Motion(unsigned seed) {
        auto changed = [&seed](Q value) {
            if (!seed) return value;
            for (int i = 0; i < 3; i++) seed = seed * 1664525u + 1013904223u;
            return value * (1 + (seed >> 31 ? 1e-16Q : -1e-16Q));
        };
        n = int(number()), law = Law(int(number())), p = number();
        damping = changed(number()), pull = changed(number()), stop = number();
        m.resize(n), k.resize(n - 1), gap.resize(n - 1), y.resize(4 * n), mode.resize(n - 1);
        x = &y[0], v = x + n, d = v + n, w = d + n, peak = List(n - 1), onset = release = List(n - 1, -1);
        for (auto [list, count] : {std::pair{m.data(), n}, {x, n}, {v, n}, {k.data(), n - 1}, {gap.data(), n - 1}})
            for (int i = 0; i < count; i++) list[i] = changed(number());
        speed = 0;
        for (int i = 0; i < n; i++) speed = std::max({speed, fabsq(v[i]), sqrtq(pull) * fabsq(x[i])});
        mass = *std::max_element(m.begin(), m.end()), initial = energy();
        overlap = powq(mass * speed * speed / *std::max_element(k.begin(), k.end()), 1 / (p + 1));
        time = overlap / speed;
        for (int j = 0; j < n - 1; j++) {
            d[j] = x[j] - x[j + 1] - gap[j], w[j] = v[j] - v[j + 1];
            if (d[j] >= 0) turn(j, 1);
        }
    }

    bool whole() const { return p == rintq(p); }

    Q energy() const {
        Q sum = 0;
        for (int i = 0; i < n; i++) sum += m[i] * (v[i] * v[i] + pull * x[i] * x[i]) / 2;
        return sum;
    }

    // A contact turns to another mode now.
    void turn(int j, char to) {
        if (!to) release[j] = t;
        if (!mode[j]) {
            if (onset[j] < 0) onset[j] = t;
            onsets.push_back(t), contacts.push_back(j + 1);
        }
        if (!to || !mode[j]) d[j] = 0;
        mode[j] = to;
    }

    // Whether nothing more is to be expected: slower approaches are rounding, and far behind a pulse contacts stay
    // closed for ages by overlaps that transmit nothing.
    bool over() const {
        const Q least = 1e-20Q;
        if (stop > 0) return t >= stop;
        for (int j = 0; j < n - 1; j++) {
            bool slow = (mode[j] ? fabsq(w[j]) : w[j]) < least * speed;
            if (!slow || (mode[j] && k[j] * powq(fabsq(d[j]), p) * time >= least * mass * speed)) return false;
        }
        return true;
    }

    void write() const {
        show("x", List(x, v)), show("v", List(v, d)), show("peak", peak), show("loss", {initial - energy()});
        show("onset", onset), show("release", release), show("times", onsets), show("contacts", contacts);
    }
};
