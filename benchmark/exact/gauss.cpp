// A row of balls by collocation at Gauss nodes, in quadruple precision: no series, and forces down to overlap 0. After
// an onset time runs as c^2 in a step, before a release as 1 - (1 - c)^2, where the force is no whole power of the
// overlap: then everything is smooth in c. A step ends where a contact switches: its length is solved for.
#include "row.hpp"

const int M = 24;
const Q TOLERANCE = 1e-20Q, SETTLED = 1e-31Q, NOISE = 1e-24Q, PI = M_PIq;
enum Map { plain, begins, ends };
enum Mode { open, closed, clipped };

struct Nodes {
    Q c[M], weight[M], phi[3][M], once[3][M][M], twice[3][M][M], end_once[3][M], end_twice[3][M], tail[2][M];
    Q inverse[M][M];  // values at nodes to Legendre coefficients

    static void legendre(Q z, Q* p, int most) {
        p[0] = 1, p[1] = z;
        for (int k = 1; k < most; k++) p[k + 1] = ((2 * k + 1) * z * p[k] - k * p[k - 1]) / (k + 1);
    }

    Nodes() {
        Q p[M + 2];
        for (int m = 0; m < M; m++) {
            Q z = -cosq(PI * (m + 0.75Q) / (M + 0.5Q)), slope = 1;
            for (int i = 0; i < 12; i++) {
                legendre(z, p, M + 1);
                slope = M * (z * p[M] - p[M - 1]) / (z * z - 1);
                z -= p[M] / slope;
            }
            c[m] = (1 + z) / 2, weight[m] = 1 / ((1 - z * z) * slope * slope);
        }
        Q integral[M][M];  // of the polynomial through the l-th node, up to the m-th
        for (int l = 0; l < M; l++) {
            legendre(2 * c[l] - 1, p, M + 1);
            for (int k = 0; k < M; k++) inverse[k][l] = (2 * k + 1) * weight[l] * p[k];
            for (int i = 0; i < 2; i++) tail[i][l] = inverse[M - 1 - i][l];
        }
        for (int m = 0; m < M; m++) {
            legendre(2 * c[m] - 1, p, M + 1);
            for (int l = 0; l < M; l++) {
                Q sum = inverse[0][l] * (p[1] + 1) / 2;
                for (int k = 1; k < M; k++) sum += inverse[k][l] * (p[k + 1] - p[k - 1]) / (2 * (2 * k + 1));
                integral[m][l] = sum;
            }
        }
        for (int map = 0; map < 3; map++) {
            Q rate[M];
            for (int m = 0; m < M; m++) {
                Q u = map == ends ? 1 - c[m] : c[m];
                phi[map][m] = map == plain ? u : map == begins ? u * u : 1 - u * u;
                rate[m] = map == plain ? 1 : 2 * u;
            }
            for (int m = 0; m < M; m++)
                for (int l = 0; l < M; l++) once[map][m][l] = integral[m][l] * rate[l];
            for (int m = 0; m < M; m++) end_once[map][m] = weight[m] * rate[m];
            for (int l = 0; l < M; l++) {
                end_twice[map][l] = 0;
                for (int m = 0; m < M; m++) {
                    twice[map][m][l] = 0;
                    for (int k = 0; k < M; k++) twice[map][m][l] += once[map][m][k] * once[map][k][l];
                    end_twice[map][l] += end_once[map][m] * once[map][m][l];
                }
            }
        }
    }
};

const Nodes nodes;

struct Gauss {
    Row row;
    int n;
    Notes notes;
    Q t = 0;
    List x, v, d, w;
    std::vector<Mode> mode;
    // Of the step that was tried last: accelerations and forces at the nodes, the state at its end.
    std::vector<List> a, f;
    List x1, v1, d1, w1;
    std::vector<char> near, bent;  // contacts with a force, balls that do not fly freely
    Q error = 0;
    long last_failure = -9;  // the step that could not end with a release

    explicit Gauss(Row r) : row(r), n(r.n), notes(n), x(r.x), v(r.v), d(n - 1), w(n - 1), mode(n - 1, open) {
        a.assign(n, List(M)), f.assign(n - 1, List(M));
        x1 = x, v1 = v, near.resize(n - 1), bent.resize(n);
        for (int j = 0; j < n - 1; j++) {
            d[j] = x[j] - x[j + 1] - row.gap[j], w[j] = v[j] - v[j + 1];
            if (d[j] >= 0) mode[j] = closed, notes.closes(j, 0);
        }
        d1 = d, w1 = w;
    }
    bool whole() const { return row.p == rintq(row.p); }

    Q force(int j, Q overlap, Q rate) const {
        Q p = row.p, k = row.k[j], c = row.damping, positive = std::max(overlap, Q(0));
        if (mode[j] != closed) return 0;
        auto power = [&](Q q, Q of) {
            return q == 0 ? 1 : q == 1 ? of : q == 1.5Q ? of * sqrtq(of) : q == 0.5Q ? sqrtq(of) : q == 2 ? of * of
                : q == 3 ? of * of * of : powq(of, q);
        };
        Q base = whole() ? overlap : positive, elastic_part = k * power(p, base);
        if (row.law == huntCrossley) return elastic_part * (1 + c * rate);
        if (row.law == viscoelastic) return elastic_part + c * k * p * power(p - 1, base) * rate;
        return row.law == elastic ? elastic_part : elastic_part + c * rate;
    }

    // Of a closed or clipped contact: has the sign of its force.
    Q sign(int j, Q overlap, Q rate) const {
        if (row.law == huntCrossley) return 1 + row.damping * rate;
        if (row.law == viscoelastic) return overlap + row.damping * row.p * rate;
        if (row.law == kelvinVoigtNoPull) return row.k[j] * powq(std::max(overlap, Q(0)), row.p) + row.damping * rate;
        return 1;
    }

    // Which contacts and balls take part: in a row in touch, those that a wave has reached, and a few beyond.
    void window() {
        bent.assign(n, row.pull != 0), near.assign(n - 1, 0);
        const Q faint = powq(1e-32Q * row.mass * row.speed / row.time, 1 / row.p);
        auto felt = [&](int j) {
            return d[j] * powq(row.k[j], 1 / row.p) > faint || fabsq(w[j]) > 1e-24Q * row.speed;
        };
        const int beyond = t > 0 ? 2 : row.p == 1 ? 12 : 6;  // it goes far in the first step
        for (int j = 0; j < n - 1; j++)
            for (int i = std::max(0, j - beyond); i <= std::min(n - 2, j + beyond) && mode[j] == closed; i++)
                near[j] = near[j] || (mode[i] == closed && felt(i));
        for (int j = 0; j < n - 1; j++)
            if (near[j]) bent[j] = bent[j + 1] = 1;
        for (int i = 0; i < n; i++)
            if (!bent[i]) a[i].assign(M, 0);
        for (int j = 0; j < n - 1; j++)
            if (!near[j]) f[j].assign(M, 0);
    }

    // One step of length h, to x1, v1, d1, w1; false if the iteration does not settle.
    bool attempt(Q h, Map map) {
        const bool rates = row.law != elastic;
        for (int iteration = 0;; iteration++) {
            if (iteration > 90) return false;
            for (int j = 0; j < n - 1; j++) {
                if (!near[j]) continue;
                List g(M);
                for (int m = 0; m < M; m++) g[m] = a[j][m] - a[j + 1][m];
                for (int m = 0; m < M; m++) {
                    Q sum = 0, change = 0;
                    for (int l = 0; l < M; l++) sum += nodes.twice[map][m][l] * g[l];
                    for (int l = 0; rates && l < M; l++) change += nodes.once[map][m][l] * g[l];
                    f[j][m] = force(j, d[j] + h * (w[j] * nodes.phi[map][m] + h * sum), w[j] + h * change);
                }
            }
            Q moved = 0;
            for (int i = 0; i < n; i++) {
                if (!bent[i]) continue;
                List next(M);
                for (int m = 0; m < M; m++) {
                    Q place = 0;
                    for (int l = 0; row.pull != 0 && l < M; l++) place += nodes.twice[map][m][l] * a[i][l];
                    place = x[i] + h * (v[i] * nodes.phi[map][m] + h * place);
                    Q push = (i ? f[i - 1][m] : 0) - (i < n - 1 ? f[i][m] : 0);
                    next[m] = push / row.m[i] - row.pull * place;
                    moved = std::max(moved, fabsq(next[m] - a[i][m]));
                }
                a[i].swap(next);
            }
            if (!(moved * h < 1e6Q * row.speed)) return false;
            if (moved * h < SETTLED * row.speed) break;
        }
        error = 0;
        for (int i = 0; i < n; i++) {
            Q once = 0, twice = 0, tail[2] = {0, 0};
            for (int l = 0; bent[i] && l < M; l++) {
                once += nodes.end_once[map][l] * a[i][l], twice += nodes.end_twice[map][l] * a[i][l];
                for (int k = 0; k < 2; k++) tail[k] += nodes.tail[k][l] * a[i][l];
            }
            v1[i] = v[i] + h * once, x1[i] = x[i] + h * (v[i] + h * twice);
            error = std::max(error, h * (fabsq(tail[0]) + fabsq(tail[1])) / row.speed);
        }
        for (int j = 0; j < n - 1; j++) {
            Q once = 0, twice = 0;
            for (int l = 0; (bent[j] || bent[j + 1]) && l < M; l++) {
                Q g = a[j][l] - a[j + 1][l];
                once += nodes.end_once[map][l] * g, twice += nodes.end_twice[map][l] * g;
            }
            w1[j] = w[j] + h * once, d1[j] = d[j] + h * (w[j] + h * twice);
        }
        return true;
    }

    struct Event { int j; Mode to; };
    // What an event waits for: its value is negative before, positive after it.
    Q waits(const Event& e, Q overlap, Q rate) const {
        if (mode[e.j] == open) return overlap;
        if (e.to == open) return -overlap;
        return (mode[e.j] == closed ? -1 : 1) * sign(e.j, overlap, rate);
    }
    Q scale(const Event& e) const {
        if (mode[e.j] == open || e.to == open || row.law == viscoelastic) return row.overlap;
        return row.law == huntCrossley ? Q(1) : row.k[e.j] * powq(row.overlap, row.p);
    }

    std::vector<Event> possible() const {
        std::vector<Event> found;
        for (int j = 0; j < n - 1; j++) {
            bool moves = bent[j] || bent[j + 1] || w[j] != 0;
            if (!moves) continue;
            if (mode[j] == open) found.push_back({j, closed});
            else if (d[j] > NOISE * row.overlap || w[j] < -NOISE * row.speed) found.push_back({j, open});
            if (row.law > kelvinVoigt && mode[j] == closed) found.push_back({j, clipped});
            if (mode[j] == clipped) found.push_back({j, closed});
        }
        return found;
    }

    // The first event within the step of length h that was tried, by its place at the nodes; -1 if there is none.
    int first(const std::vector<Event>& events, Q h, Map map, Q& guess) const {
        int which = -1;
        guess = h;
        for (size_t e = 0; e < events.size(); e++) {
            int j = events[e].j;
            Q least = NOISE * scale(events[e]), before_at = 0, before = waits(events[e], d[j], w[j]);
            bool free = !bent[j] && !bent[j + 1];
            for (int m = 0; m <= M; m++) {
                if (free && m < M) continue;
                Q at = m < M ? h * nodes.phi[map][m] : h, overlap = d1[j], rate = w1[j];
                if (m < M) {
                    Q once = 0, twice = 0;
                    for (int l = 0; l < M; l++) {
                        Q g = a[j][l] - a[j + 1][l];
                        twice += nodes.twice[map][m][l] * g, once += nodes.once[map][m][l] * g;
                    }
                    overlap = d[j] + h * (w[j] * nodes.phi[map][m] + h * twice), rate = w[j] + h * once;
                }
                Q value = waits(events[e], overlap, rate);
                if (value > least && value > before) {
                    Q crossing = before < 0 ? at - (at - before_at) * value / (value - before) : before_at;
                    if (which < 0 || crossing < guess) guess = crossing, which = int(e);
                    break;
                }
                before = value, before_at = at;
            }
        }
        return which;
    }

    // Solves for the length of the step that ends at the event: secants within a bracket.
    bool solve(const Event& event, Q& h, Q most, Map map) {
        Q low = 0, high = most, low_value = waits(event, d[event.j], w[event.j]), high_value = 0, h0 = 0;
        Q value0 = low_value;
        for (int i = 0; i < 60; i++) {
            if (!attempt(h, map) || (map == ends && i > 3 && (i > 14 || error > 1e4Q * TOLERANCE))) return false;
            Q value = waits(event, d1[event.j], w1[event.j]);
            if (fabsq(value) < 1e-31Q * scale(event)) return true;
            (value > 0 ? high : low) = h, (value > 0 ? high_value : low_value) = value;
            Q next = h - value * (h - h0) / (value - value0);
            if (i % 8 == 7 || !(next > low && next < high)) next = (low + high) / 2;
            if (fabsq(next - h) < 1e-32Q * (t + h) || fabsq(next - h) < 1e-33Q * h) return true;
            h0 = h, value0 = value, h = next;
        }
        return true;
    }

    void accept(Q h) {
        for (int j = 0; j < n - 1; j++) {
            if (!near[j] || mode[j] != closed) continue;
            Q top = force(j, d[j], w[j]), last = force(j, d1[j], w1[j]), inner = 0;
            for (Q value : f[j]) inner = std::max(inner, value);
            notes.force(j, top), notes.force(j, last);
            if (std::max(inner, last) < notes.peak[j] * 0.9Q) continue;
            Q legendre[M + 2], coefficient[M];
            for (int k = 0; k < M; k++) {
                coefficient[k] = 0;
                for (int l = 0; l < M; l++) coefficient[k] += nodes.inverse[k][l] * f[j][l];
            }
            auto at = [&](Q c) {
                Q sum = 0;
                Nodes::legendre(2 * c - 1, legendre, M);
                for (int k = 0; k < M; k++) sum += coefficient[k] * legendre[k];
                return sum;
            };
            Q low = 0, high = 1, ratio = (sqrtq(5) - 1) / 2;
            for (int i = 0; i < 75; i++) {
                Q left = high - ratio * (high - low), right = low + ratio * (high - low);
                if (at(left) < at(right)) low = left; else high = right;
            }
            notes.force(j, at((low + high) / 2));
        }
        x = x1, v = v1, d = d1, w = w1, t += h;
    }

    // A step that ends with a release that is near, to x1 and so on: its length, or 0 if there is none.
    Q release_step(const std::vector<Event>& events, Q h, Q left, long step) {
        int which = -1;
        Q soon = 0, guess = 0;
        for (size_t e = 0; e < events.size(); e++) {
            int j = events[e].j;
            // Viscoelastic contacts have been clipped before. An overlap that transmits nothing does no harm.
            if (mode[j] != closed || events[e].to != open || row.law == viscoelastic) continue;
            if (w[j] >= 0 || d[j] <= 0) continue;
            if (row.k[j] * powq(d[j], row.p) * row.time <= 1e-22Q * row.mass * row.speed) continue;
            if (d[j] < -1.5Q * w[j] * h && (which < 0 || -d[j] / w[j] < soon)) soon = -d[j] / w[j], which = int(e);
        }
        if (which < 0 || soon >= std::min(left, 0.15Q * row.time) || step <= last_failure + 3) return 0;
        last_failure = step;
        Q length = soon;
        if (!solve(events[which], length, 3 * soon, ends) || error >= TOLERANCE) return 0;
        int other = first(events, length, ends, guess);
        if (other >= 0 && other != which) return 0;
        last_failure = -9;
        return length;
    }

    // A step of at most h, which ends at the first event within it: its length. `met`: whether there is one.
    Q step(const std::vector<Event>& events, Q h, Map map, bool& met) {
        for (int i = 0; i < 200; i++) {
            if (!attempt(h, map) || error > TOLERANCE) {
                bool settled = error > TOLERANCE && error < 1e9Q;
                h *= settled ? std::max(Q(0.3), 0.85Q * powq(TOLERANCE / error, Q(1) / M)) : Q(0.4);
                error = 0;
                continue;
            }
            Q guess = 0;
            int which = first(events, h, map, guess);
            met = which >= 0;
            if (!met) return h;
            for (int k = 0; k < 8; k++) {
                Q length = guess > 0 ? guess : 1e-3Q * h;
                if (!solve(events[which], length, h, map)) break;
                int other = first(events, length, map, guess);
                if (other < 0 || other == which || length - guess < 1e-28Q * (t + length)) return length;
                which = other;
            }
            h /= 2;
        }
        throw std::string("no step succeeds");
    }

    // Switches the contacts whose events are due; whether one of them closes.
    bool switches(const std::vector<Event>& events) {
        bool onset = false;
        for (auto& event : events) {
            int j = event.j;
            if (fabsq(waits(event, d[j], w[j])) >= NOISE * scale(event)) continue;
            if ((event.to == open && w[j] > 0) || (mode[j] == open && w[j] <= 0)) continue;
            if (mode[j] == open) notes.closes(j, t), d[j] = 0, onset = true;
            if (event.to == open) notes.opens(j, t), d[j] = 0;
            mode[j] = event.to;
        }
        return onset;
    }

    bool over() const {
        if (row.stop > 0) return t >= row.stop * (1 - 1e-33Q);
        for (int j = 0; j < n - 1; j++)
            if (!rests(row, j, mode[j] == open, d[j], w[j])) return false;
        return true;
    }

    void go() {
        const Q rest = row.pull != 0 ? 0.3Q / sqrtq(row.pull) : 0;
        bool onset = std::count(mode.begin(), mode.end(), closed) > 0, flies = !onset;
        Q h = onset ? row.time / 10 : rest;
        for (long number = 0; !over(); number++) {
            if (number > 3000000) throw std::string("too many steps");
            window();
            auto events = possible();
            if (flies && rest == 0) {  // beyond the next onset, which is found then
                h = 0;
                for (int j = 0; j < n - 1; j++)
                    if (w[j] > 0 && (h == 0 || -1.01Q * d[j] / w[j] < h)) h = -1.01Q * d[j] / w[j];
            }
            Q left = row.stop > 0 ? row.stop - t : h, length = 0;
            Map map = onset && !whole() ? begins : plain;
            bool met = true;
            if (map == plain && !whole()) length = release_step(events, h, left, number);
            if (length > 0) map = ends;
            else length = step(events, std::min(h, left), map, met);
            Q next = length * std::min(Q(3), std::max(Q(0.3), 0.9Q * powq(TOLERANCE / (error + 1e-60Q), Q(1) / M)));
            h = met ? std::max(h, next) : next;
            accept(length);
            onset = met && switches(events);
            if (onset) h = std::min(h, row.time / 5);
            if (map == ends) h = std::max(h, row.time / 4);
            bool now = std::count(mode.begin(), mode.end(), open) == n - 1;
            if (now && !flies) h = rest;
            flies = now;
        }
        write(row, notes, x, v);
    }
};

int main(int count, char** words) { return start<Gauss>(count, words); }
