// What both computations share: how a row is read, its motion and what is noted of it, how results are written.
#pragma once
#include <quadmath.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <utility>
#include <valarray>
#include <vector>

using Q = __float128;
using List = std::valarray<Q>;

enum Law { elastic, kelvinVoigt, kelvinVoigtNoPull, huntCrossley, viscoelastic, constantRestitution };

// The damping ratio of a linear spring and damper that never pull, by which two bodies part at this coefficient of
// restitution, above exp(-2): cos(beta) with beta cot(beta) = -log(e)/2.
inline Q ratio(Q restitution) {
    Q low = 0, high = M_PI_2q;
    for (int i = 0; i < 120; i++) {
        Q beta = (low + high) / 2;
        (beta * cosq(beta) > -logq(restitution) / 2 * sinq(beta) ? low : high) = beta;
    }
    return cosq(low);
}

inline void show(const char* name, const List& list) {
    char text[64];
    std::cout << name;
    for (Q value : list) quadmath_snprintf(text, sizeof text, "%.26Qe", value), std::cout << " " << text;
    std::cout << "\n";
}

// A row and its motion, from the program's standard input; its argument is the seed.
struct Motion {
    int n;
    Law law;
    Q p, damping, pull, stop;          // exponent, coefficient of the law, g/L (1/s2), end (s)
    Q root;                            // of constantRestitution: (p - 1)/2, the power of the overlap in its damping
    Q mass, speed = 0, time, initial;  // scales: a mass, the largest speed, the time of a contact; energy at the start
    Q t = 0;
    List m, k, y, peak, c;   // c: factors of that damping
    Q *x, *v, *d, *w;        // in y: of balls, and overlaps and their rates
    std::vector<char> mode;  // of contacts; 0: open

    // The row is apart or in touch. With a seed but 0, each value is changed by 1e-16 of itself, up or down by chance.
    Motion(unsigned seed) {
        auto number = [] { double value; std::cin >> value; return Q(value); };
        auto changed = [&] {
            for (int i = 0; seed && i < 3; i++) seed = seed * 1664525u + 1013904223u;
            return number() * (1 + (!seed ? 0 : seed >> 31 ? 1e-16Q : -1e-16Q));
        };
        n = int(number()), law = Law(int(number())), p = number(), stop = number();
        damping = changed(), pull = changed(), root = (p - 1) / 2;
        m.resize(n), k.resize(n - 1), y.resize(4 * n), peak.resize(n - 1), c.resize(n - 1), mode.resize(n);
        x = &y[0], v = x + n, d = v + n, w = d + n;
        for (auto [list, count] : {std::pair{&m[0], n}, {x, n}, {v, n}, {&k[0], n - 1}, {d, n - 1}})  // gaps, at first
            for (int i = 0; i < count; i++) list[i] = changed();
        for (int j = 0; law == constantRestitution && j < n - 1; j++) {
            Q reduced = m[j] * m[j + 1] / (m[j] + m[j + 1]);
            c[j] = 2 * ratio(damping) * sqrtq((p + 1) / 2 * k[j] * reduced);
        }
        for (int i = 0; i < n; i++) speed = std::max({speed, fabsq(v[i]), sqrtq(pull) * fabsq(x[i])});
        mass = m.max(), initial = energy(), time = powq(mass * speed * speed / k.max(), 1 / (p + 1)) / speed;
        for (int j = 0; j < n - 1; j++) {
            d[j] = x[j] - x[j + 1] - d[j], w[j] = v[j] - v[j + 1];
            if (d[j] >= 0) turn(j, 1);
        }
    }

    bool whole() const { return p == rintq(p) && (law != constantRestitution || root == rintq(root)); }

    Q energy() const {
        Q sum = 0;
        for (int i = 0; i < n; i++) sum += m[i] * (v[i] * v[i] + pull * x[i] * x[i]) / 2;
        return sum;
    }

    // A contact turns to another mode now.
    void turn(int j, char to) {
        if (!to || !mode[j]) show(to ? "closed" : "opened", {Q(j + 1), t}), d[j] = 0;
        mode[j] = to;
    }

    // Whether nothing more is to be expected: slower approaches are rounding, and far behind a pulse contacts stay
    // closed for ages by overlaps that transmit nothing.
    bool over() const {
        const Q least = 1e-20Q;
        if (pull != 0 || t >= stop) return t >= stop;
        for (int j = 0; j < n - 1; j++) {
            bool slow = (mode[j] ? fabsq(w[j]) : w[j]) < least * speed;
            if (!slow || (mode[j] && k[j] * powq(fabsq(d[j]), p) * time >= least * mass * speed)) return false;
        }
        return true;
    }

    void write() const {
        show("x", {x, size_t(n)}), show("v", {v, size_t(n)}), show("peak", peak), show("loss", {initial - energy()});
    }
};
