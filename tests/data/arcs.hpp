// Integrates balls in quadruple precision, on arcs for arcs.cpp and random_arcs.cpp, on a line for rows.cpp.
//
// The state is the angles and their rates, on a line the positions over the lengths; overlaps are computed from the positions, which quadruple precision allows.
// Rigid balls rebound along the line of their centres.
// Integration is by collocation at Gauss nodes, in steps that end where a contact switches. After a switching time runs
// as c^q in a step, before an opening as 1 - (1 - c)^q, so that forces that start like a root are smooth in c.
// Each run is repeated with fewer nodes and a looser tolerance. A third run, with the starts changed by about 1e-16,
// shows how much that grows: the `sensitivity`. The difference of the first two over it must stay below
// 1e-18, the error of the energy, whose losses are a mere quadrature, below 1e-14 (of rows 1e-12). They go to stderr.
#pragma once
#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

using Q = __float128;
using List = std::vector<Q>;
using Rows = std::vector<List>;
const Q NOISE = 1e-30Q, GRAVITY = 9.81, RADIUS = 0.0313, LENGTH = 1.962;
enum Law { elastic, kelvinVoigt, kelvinVoigtNoPull, huntCrossley, viscoelastic, constantRestitution, rigid };
const char* const LAWS[] = {"none", "kelvinVoigt", "kelvinVoigtNoPull", "huntCrossley", "viscoelastic",
                            "constantRestitution", "rigid"};
enum Map { plain, begins, ends };
enum Mode { open, pressing, clipped };

struct Case {
    std::vector<double> degrees;  // of ball 1 and those that hang on as long a string; others as far to the side
    Law law;
    double p, k, coefficient, deadBand;   // p: a number of quarters
    std::vector<double> lengths, masses;  // ratios to 1.962 m and 1 kg; empty: 1
    double drag, support;                 // N.s/m, m/s2
    std::vector<double> gaps = {};        // m; empty: 0
    std::vector<double> forces = {};      // N; empty: 0
    std::vector<double> losses = {};      // ratios of the contacts' losses; empty: 1
    bool line = false;                    // whether the balls move on a line
};
// Damping ratio of a contact that two balls alone leave at e times their speed of approach: by bisection from
// e = exp(-2 b / tan b) with cos b, beyond critical damping exp(-2 b / tanh b) with cosh b.
inline Q dampingRatio(Q e) {
    Q h = -logq(e) / 2, low = 0, high = h < 1 ? M_PI_2q : h;
    for (int i = 0; i < 200; i++) {
        const Q b = (low + high) / 2, of = h < 1 ? -b / tanq(b) : b / tanhq(b);
        ((h < 1 ? -of < h : of > h) ? high : low) = b;
    }
    return h < 1 ? cosq(low) : coshq(low);
}
struct Nodes {  // on 0 .. 1; `integral` of what is known at the nodes from 0 to each of them
    int count;
    List c, weight;
    Rows integral, tail;  // `tail`: the last two Legendre coefficients

    static Q legendre(int k, Q z) {
        Q before = 1, p = z;
        for (int i = 2; i <= k; i++) std::tie(before, p) = std::pair(p, ((2 * i - 1) * z * p - (i - 1) * before) / i);
        return k ? p : 1;
    }
    explicit Nodes(int n) : count(n), c(n), weight(n), integral(n, List(n)), tail(2, List(n)) {
        for (int m = 0; m < n; m++) {
            Q z = -cosq(M_PIq * (m + 0.75Q) / (n + 0.5Q)), slope = 1;
            for (int i = 0; i < 12; i++) {
                slope = n * (z * legendre(n, z) - legendre(n - 1, z)) / (z * z - 1);
                z -= legendre(n, z) / slope;
            }
            c[m] = (1 + z) / 2, weight[m] = 1 / ((1 - z * z) * slope * slope);
            for (int i = 0; i < 2; i++) tail[i][m] = (2 * (n - i) - 1) * weight[m] * legendre(n - 1 - i, z);
        }
        for (int m = 0; m < n; m++)
            for (int l = 0; l < n; l++) {
                Q z = 2 * c[m] - 1, sum = c[m];
                for (int k = 1; k < n; k++)
                    sum += legendre(k, 2 * c[l] - 1) * (legendre(k + 1, z) - legendre(k - 1, z)) / 2;
                integral[m][l] = weight[l] * sum;
            }
    }
};

struct State {
    List angle, rate;
    Q loss = 0;
};

struct Run {
    const Case& given;
    const Nodes& nodes;
    const Q tolerance;
    int n, power, steps = 0, onsets = 0;  // power: q of the time
    int attempts = 0, most = 1 << 30;     // of steps
    List L, m, f, C;                      // f: acceleration by the inputs; C: of the damping of each contact
    State now, then;  // then: at the end of the step that was tried
    Q t = 0, speed = 0, error = 0;
    Rows a;  // accelerations of the angles at the nodes
    std::vector<State> at;
    std::vector<Mode> mode;

    Run(const Case& given, const Nodes& nodes, Q tolerance, const List& x, const List& v = {})
        : given(given), nodes(nodes), tolerance(tolerance), n(int(x.size())), mode(n - 1, open) {
        power = given.law != constantRestitution && 4 * given.p == floor(2 * given.p) * 2 ? 2 : 4;
        for (int i = 0; i < n; i++) {
            L.push_back(given.lengths.empty() ? LENGTH : LENGTH * Q(given.lengths[i]));
            m.push_back(given.masses.empty() ? 1 : given.masses[i]);
            f.push_back((given.forces.empty() ? 0 : given.forces[i] / m[i]) - given.support);
            now.angle.push_back(given.line ? x[i] / L[i] : asinq(x[i] / L[i]));
            now.rate.push_back(v.empty() ? 0 : v[i] / (L[i] * (given.line ? 1 : cosq(now.angle[i]))));
            speed = std::max({speed, sqrtq(GRAVITY * L[i]) * fabsq(now.angle[i]), L[i] * fabsq(now.rate[i])});
        }
        for (int j = 0; j < n - 1; j++) {
            const Q loss = given.losses.empty() ? 1 : given.losses[j], reduced = m[j] * m[j + 1] / (m[j] + m[j + 1]);
            if (given.law != constantRestitution) C.push_back(given.coefficient * loss);
            else C.push_back(dampingRatio(powq(given.coefficient, loss)) * sqrtq(2 * (given.p + 1) * reduced * given.k));
        }
        a.assign(nodes.count, List(n)), at.assign(nodes.count, now);
    }

    // Contact j: unit vector from ball j to j + 1, distance, overlap and its rate, elastic force, force, its sign.
    struct Contact { Q x, y, D, d, r, spring, force, sign; };
    void direct(Q angle, Q* s, Q* c) const {  // sine and cosine; of small angles on a line
        if (given.line) *s = angle, *c = 1;
        else sincosq(angle, s, c);
    }
    Contact contact(int j, const State& state) const {
        Q s[2], c[2];
        for (int i = 0; i < 2; i++) direct(state.angle[j + i], s + i, c + i);
        return contact(j, state, s, c);
    }
    Contact contact(int j, const State& state, const Q* s, const Q* c) const {  // the sines and cosines of both angles
        const Q v[] = {L[j] * state.rate[j], L[j + 1] * state.rate[j + 1]};
        Q x = 2 * RADIUS + (given.gaps.empty() ? 0 : given.gaps[j]) + L[j + 1] * s[1] - L[j] * s[0];
        Q y = L[j + 1] * (1 - c[1]) - L[j] * (1 - c[0]);
        Q D = sqrtq(x * x + y * y), d = 2 * RADIUS - given.deadBand - D, closed = std::max(d, Q(0));
        Q r = -(x * (v[1] * c[1] - v[0] * c[0]) + y * (v[1] * s[1] - v[0] * s[0])) / D;
        Q root = given.p == 1 ? 1 : sqrtq(closed);  // closed^(p - 1)
        if (given.p != 1 && given.p != 1.5) {
            const Q fourth = sqrtq(root);
            root = 1;
            for (int i = 4; i < 4 * given.p; i++) root *= fourth;
        }
        Q spring = given.k * closed * root, force = spring, sign = 1;
        const Q C = this->C[j];
        if (given.law == kelvinVoigt || given.law == kelvinVoigtNoPull) force += C * r;
        if (given.law == kelvinVoigtNoPull) sign = closed * root + C / given.k * r;
        if (given.law == huntCrossley) sign = 1 + C * r, force *= sign;
        if (given.law == viscoelastic) sign = closed + given.p * C * r, force = given.k * root * sign;
        if (given.law == constantRestitution) {
            const Q half = sqrtq(root);
            sign = closed * half + C / given.k * r, force = given.k * half * sign;
        }
        return {x / D, y / D, D, d, r, spring, mode[j] == pressing ? force : 0, sign};
    }
    // Accelerations of the angles; the result is the power lost.
    Q accelerate(const State& state, List& a) const {
        Q lost = 0;
        List s(n), c(n);
        for (int i = 0; i < n; i++) {
            direct(state.angle[i], &s[i], &c[i]);
            a[i] = (-GRAVITY * s[i] + f[i] * c[i]) / L[i] - given.drag / m[i] * state.rate[i];
            lost += given.drag * L[i] * L[i] * state.rate[i] * state.rate[i];
        }
        for (int j = 0; j < n - 1; j++) {
            if (mode[j] == open) continue;
            Contact of = contact(j, state, &s[j], &c[j]);
            for (int i : {j, j + 1})
                a[i] += (i == j ? -1 : 1) * of.force * (of.x * c[i] + of.y * s[i]) / (m[i] * L[i]);
            lost += (of.force - of.spring) * of.r;
        }
        return lost;
    }
    Q raised(Q c, int n) const { return n ? c * raised(c, n - 1) : 1; }
    Q phi(Map map, Q c) const {
        return map == plain ? c : map == begins ? raised(c, power) : 1 - raised(1 - c, power);
    }
    // One step of length h; false if it is not as exact as it should be.
    bool attempt(Q h, Map map) {
        if (attempts++ > most) throw std::runtime_error("too many steps");
        const int N = nodes.count;
        List slope(N), lost(N);
        Rows within = nodes.integral;
        for (int l = 0; l < N; l++) {
            slope[l] = h;
            if (map != plain) slope[l] *= power * raised(map == begins ? nodes.c[l] : 1 - nodes.c[l], power - 1);
            for (int k = 0; k < N; k++) within[k][l] *= slope[l];
            accelerate(now, a[l]);
        }
        auto sum = [N](const List& weights, auto what) {
            Q total = 0;
            for (int l = 0; l < N; l++) total += weights[l] * what(l);
            return total;
        };
        Q moved = 0, before = 1e30Q;
        for (int round = 0; round < 80 && before > 1e-29Q; round++) {
            for (int i = 0; i < n; i++) {
                for (int l = 0; l < N; l++)
                    at[l].rate[i] = now.rate[i] + sum(within[l], [&](int k) { return a[k][i]; });
                for (int l = 0; l < N; l++)
                    at[l].angle[i] = now.angle[i] + sum(within[l], [&](int k) { return at[k].rate[i]; });
            }
            moved = 0;
            for (int l = 0; l < N; l++) {
                List last = a[l];
                lost[l] = accelerate(at[l], a[l]);
                for (int i = 0; i < n; i++) moved = std::max(moved, fabsq(a[l][i] - last[i]) * h * L[i] / speed);
            }
            if (!(moved < 1e6Q)) return false;
            if (moved < 1e-25Q && moved > before / 2) break;  // rounding
            before = moved;
        }
        then = now, error = moved < 1e-25Q ? 0 : 1;
        for (int i = 0; i < n; i++) {
            then.angle[i] += sum(nodes.weight, [&](int l) { return slope[l] * at[l].rate[i]; });
            then.rate[i] += sum(nodes.weight, [&](int l) { return slope[l] * a[l][i]; });
            for (auto& tail : nodes.tail)
                error = std::max(error, fabsq(sum(tail, [&](int l) { return slope[l] * a[l][i]; })) * L[i] / speed);
        }
        then.loss += sum(nodes.weight, [&](int l) { return slope[l] * lost[l]; });
        return error < tolerance;
    }
    // A contact switches where a value becomes positive.
    struct Switch { int j; Mode to; };
    Q value(Switch s, const State& state) const {
        Contact of = contact(s.j, state);
        return s.to == open ? -of.d : mode[s.j] == open ? of.d : s.to == clipped ? -of.sign : of.sign;
    }
    // The first switch within the step of length h that was tried: its place, as a share of h; 2: there is none;
    // -1: balls may touch between two nodes, above which the tangents to the overlap meet.
    Q first(Q h, Map map, Switch& found) const {
        Q best = 2;
        std::vector<Switch> possible;
        for (int j = 0; j < n - 1; j++) {
            possible.push_back({j, mode[j] == open ? pressing : open});
            if (mode[j] != open && given.law >= kelvinVoigtNoPull && C[j] > 0)
                possible.push_back({j, mode[j] == pressing ? clipped : pressing});
        }
        for (Switch s : possible) {
            Q before = value(s, now), from = 0, r = contact(s.j, now).r;
            for (int l = 0; l <= nodes.count; l++) {
                const State& state = l < nodes.count ? at[l] : then;
                Q to = l < nodes.count ? phi(map, nodes.c[l]) : 1, after = value(s, state), r1 = contact(s.j, state).r;
                if (after > NOISE) {
                    Q place = before < -NOISE ? from + (to - from) * before / (before - after) : from;
                    if (place < best) best = place, found = s;
                    break;
                }
                Q top = before + r * (after - before - r1 * h * (to - from)) / (r - r1);
                if (mode[s.j] == open && r > 0 && r1 < 0 && top > 0) return -1;
                before = after, from = to, r = r1;
            }
        }
        return best;
    }
    // A step that ends where the contact switches, of length h; false if there is none as exact.
    bool solve(Switch s, Q& h, Q most, Map map) {
        Q low = 0, high = most, h0 = 0, value0 = value(s, now);
        for (int i = 0; i < 40; i++) {
            if (!attempt(h, map) && (i > 3 || error >= 1)) return false;
            Q after = value(s, then), next = h - after * (h - h0) / (after - value0);
            (after > 0 ? high : low) = h;
            if (fabsq(after) < 1e-33Q || !(next > low && next < high) || fabsq(next - h) < 1e-31Q * h) break;
            h0 = h, value0 = after, h = next;
        }
        return error < tolerance && fabsq(value(s, then)) < NOISE;
    }
    // Impacts of two rigid balls that touch, the fastest first, until none approach each other.
    void collide() {
        const Q e = given.coefficient;
        while (true) {
            Contact of{};
            int i = 0;
            for (int j = 0; j < n - 1; j++) {
                Contact other = contact(j, now);
                if (fabsq(other.d) < NOISE && other.r > of.r) of = other, i = j;
            }
            if (of.r < 1e-27Q) return;
            Q way[2], mobility = 0;
            for (int k : {0, 1}) {
                way[k] = of.x * cosq(now.angle[i + k]) + of.y * sinq(now.angle[i + k]);
                mobility += way[k] * way[k] / m[i + k];
            }
            for (int k : {0, 1})
                now.rate[i + k] += (k ? 1 : -1) * (1 + e) * of.r / mobility * way[k] / (m[i + k] * L[i + k]);
            now.loss += (1 - e * e) * of.r * of.r / mobility / 2;
            onsets++;
        }
    }
    void turn(Switch s) {
        if (given.law == rigid) collide();
        else mode[s.j] = s.to;
    }
    // What no cradle does on its strings.
    void check() const {
        if (given.line) return;
        for (int i = 0; i < n; i++) {
            const Q angle = now.angle[i], rate = now.rate[i];
            if (fabsq(angle) > M_PI_2q) throw std::runtime_error("horizontal");
            bool touches = (i > 0 && mode[i - 1] != open) || (i < n - 1 && mode[i] != open);
            Q tension = L[i] * rate * rate + GRAVITY * cosq(angle) + f[i] * sinq(angle);
            if (!touches && tension < 0) throw std::runtime_error("slack");
        }
        for (int j = 0; j < n - 1; j++) {  // a centre on the other ball's string
            const Contact of = contact(j, now);
            for (int i : {j, j + 1}) {
                Q s, c;
                sincosq(now.angle[i], &s, &c);
                const Q up = (i == j ? -1 : 1) * (of.x * s - of.y * c) * of.D;
                if (of.x * c + of.y * s <= 0 && up >= 0 && up < L[i]) throw std::runtime_error("across");
            }
        }
    }
    void go(Q end) {
        const Q flight = 0.02Q * sqrtq(LENGTH / GRAVITY);
        Q h = flight, contact_step = 1e-6Q;
        bool fresh = true;  // a contact has just closed
        while (t < end) {
            Map map = fresh ? begins : plain;
            Q length = std::min(h, end - t);
            Switch s{-1, open};
            if (!attempt(length, map)) {
                h = 0.4Q * length;
                continue;
            }
            Q share = first(length, map, s);
            bool meets = share < 2;
            if (share == 0) {
                turn(s);
                continue;
            }
            if (meets) {
                Q whole = length;
                bool opens = s.to == open;
                if (opens) map = ends;
                length = share * whole;
                bool solved = share > 0 && !(opens && fresh) && solve(s, length, whole, map);
                if (!solved || first(length, map, s) < 1 - 1e-9Q) {
                    h = fabsq(share) * whole / 2;
                    continue;
                }
            }
            now = then, t += length, steps++;
            check();
            if (fresh) contact_step = length;
            Q grown = length * std::min(Q(3), 0.9Q * powq(tolerance / (error + 1e-60Q), Q(1) / nodes.count));
            h = meets ? std::max(h, grown) : grown, fresh = false;
            if (!meets) continue;
            turn(s);
            if (mode[s.j] == pressing) fresh = true, onsets++;
            for (int j = 0; j < n - 1 && given.law != rigid; j++) {  // others at the same time, and balls in touch
                Contact of = contact(j, now);
                if (fabsq(of.d) < NOISE && mode[j] == open && of.r > -1e-27Q) mode[j] = pressing, fresh = true;
                if (fabsq(of.d) < NOISE && mode[j] != open && of.r < -1e-27Q) mode[j] = open;
            }
            if (fresh) h = std::min(h, 2 * contact_step);
            if (std::count(mode.begin(), mode.end(), open) == n - 1) h = flight;
        }
    }
    Q energy() const {  // with what has been lost, J
        Q sum = now.loss;
        for (int i = 0; i < n; i++) {
            Q half, whole, unused, v = L[i] * now.rate[i];
            direct(now.angle[i] / 2, &half, &unused), direct(now.angle[i], &whole, &unused);
            sum += m[i] * (v * v / 2 + 2 * GRAVITY * L[i] * half * half - f[i] * L[i] * whole);
        }
        for (int j = 0; j < n - 1; j++) {
            Contact of = contact(j, now);
            if (mode[j] != open) sum += of.spring * of.d / (Q(given.p) + 1);
        }
        return sum;
    }
    Rows state() const {  // x, v, angle
        Rows rows(3, List(n));
        for (int i = 0; i < n; i++) {
            Q s, c;
            direct(now.angle[i], &s, &c);
            rows[0][i] = L[i] * s, rows[1][i] = L[i] * now.rate[i] * c, rows[2][i] = now.angle[i];
        }
        return rows;
    }
    Q off(const Run& other) const {  // the largest difference of a position or velocity
        Rows one = state(), two = other.state();
        Q worst = 0;
        for (int k : {0, 1})
            for (int i = 0; i < n; i++) worst = std::max(worst, fabsq(one[k][i] - two[k][i]));
        return worst;
    }
};

// Numbers of quadruple precision as strings of 20 digits, doubles as they are.
template <class T> std::string shown(const char* name, const std::vector<T>& values, const char* end) {
    std::string line = std::string("\"") + name + "\": [";
    for (size_t i = 0; i < values.size(); i++) {
        char text[64];
        quadmath_snprintf(text, sizeof text, sizeof(T) > 8 ? "%.19Qe" : "%.17Qg", Q(values[i]));
        const char* quote = sizeof(T) > 8 ? "\"" : "";
        line += std::string(i ? ", " : "") + quote + text + quote;
    }
    return line + "]" + end;
}
template <class T> void show(const char* name, const std::vector<T>& values, const char* end) {
    fputs(shown(name, values, end).c_str(), stdout);
}
