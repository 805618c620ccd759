// A row of balls by Taylor series of its whole motion, in quadruple precision. A step ends where a contact switches.
// A force that is no whole power of the overlap has no series at overlap 0: steps shrink towards it and grow from it,
// and forces whose impulse is below 1e-32 of the row's are left out ("faint"). They are left out until a row in touch
// feels them, too. Overlaps are carried on by themselves: no digits are lost where they are small.
#include "row.hpp"

enum Mode { open, faint, pressing, clipped };
const int N = 36;
const Q LEFT_OUT = 1e-32Q, ERROR = 1e-25Q, FAR = 1e4000Q;

struct Poly {
    const Q* c;
    int degree;
    Q operator()(Q t) const {
        Q sum = 0;
        for (int k = degree; k >= 0; k--) sum = sum * t + c[k];
        return sum;
    }
    Q slope(Q t) const {
        Q sum = 0;
        for (int k = degree; k >= 1; k--) sum = sum * t + k * c[k];
        return sum;
    }
};

// The first time within (0, end] at which sign * (polynomial - level) becomes positive; FAR if it does not.
Q first(Poly poly, Q level, int sign, Q end) {
    Q start = sign * (poly.c[0] - level), moved = 0, power = 1;
    if (poly.degree == 1) {
        if (start > 0) return 0;
        Q rate = sign * poly.c[1], t = rate > 0 ? -start / rate : FAR;
        return t <= end ? t : FAR;
    }
    for (int k = 1; k <= poly.degree; k++) power *= end, moved += fabsq(poly.c[k]) * power;
    if (start <= 0 && start + moved < 0) return FAR;
    const int pieces = 12;
    for (int piece = 1; piece <= pieces; piece++) {
        Q a = end * (piece - 1) / pieces, b = end * piece / pieces;
        if (sign * (poly(b) - level) <= 0) continue;
        if (sign * (poly(a) - level) > 0) return a;
        for (int i = 0; i < 110; i++) {
            Q middle = (a + b) / 2;
            (sign * (poly(middle) - level) > 0 ? b : a) = middle;
        }
        return b;
    }
    return FAR;
}

struct Taylor {
    Row row;
    int n;
    Notes notes;
    Q t = 0;
    List x, v, d, w;
    std::vector<Mode> mode;
    std::vector<List> X, D, P, S, F;  // series: positions, overlaps, their power and square, forces
    std::vector<char> acts, bent;     // contacts with a force, balls that do not fly freely

    explicit Taylor(Row r) : row(r), n(r.n), notes(n), x(r.x), v(r.v), d(n - 1), w(n - 1), mode(n - 1, open) {
        X.assign(n, List(N + 1)), D = P = S = F = std::vector<List>(n - 1, List(N + 1));
        acts.resize(n - 1), bent.resize(n);
        for (int j = 0; j < n - 1; j++) {
            d[j] = x[j] - x[j + 1] - row.gap[j], w[j] = v[j] - v[j + 1];
            if (d[j] >= 0) mode[j] = whole() ? pressing : faint, notes.closes(j, 0);
        }
    }
    bool whole() const { return row.p == rintq(row.p); }
    bool viscous() const { return row.law == kelvinVoigt || row.law == kelvinVoigtNoPull; }

    // The overlap below which a contact's elastic force is left out.
    Q least(int j) const {
        Q left_out = LEFT_OUT * row.mass * row.speed, p = row.p;
        Q slow = powq(left_out / (row.k[j] * row.time), 1 / p);
        Q fast = powq((p + 1) * fabsq(w[j]) * left_out / row.k[j], 1 / (p + 1));
        if (row.law == viscoelastic) fast = std::min(fast, powq(left_out / (row.k[j] * row.damping), 1 / p));
        return std::max(slow, fast);
    }

    Q power(int j, int k) {
        const List& c = D[j];
        Q sum = 0;
        if (row.p == 1) return P[j][k] = c[k];
        if (whole()) {
            for (int i = 0; i <= k; i++) sum += c[i] * c[k - i];
            S[j][k] = sum;
            if (row.p == 3) {
                sum = 0;
                for (int i = 0; i <= k; i++) sum += S[j][i] * c[k - i];
            }
            return P[j][k] = sum;
        }
        if (k == 0) return P[j][0] = powq(c[0], row.p);
        for (int i = 1; i <= k; i++) sum += ((row.p + 1) * i - k) * c[i] * P[j][k - i];  // J. C. P. Miller
        return P[j][k] = sum / (k * c[0]);
    }

    Q force(int j, int k) {
        Q elastic_part = 0, a = row.damping;
        if (mode[j] == pressing) {
            if (k == 0) power(j, 0);
            power(j, k + 1);
            elastic_part = P[j][k];
            if (row.law == viscoelastic) elastic_part += a * (k + 1) * P[j][k + 1];
            if (row.law == huntCrossley)
                for (int i = 0; i <= k; i++) elastic_part += a * (i + 1) * D[j][i + 1] * P[j][k - i];
        }
        return row.k[j] * elastic_part + (viscous() ? a * (k + 1) * D[j][k + 1] : 0);
    }

    Q series() {
        for (int j = 0; j < n - 1; j++)
            acts[j] = mode[j] == pressing || (mode[j] == faint && viscous());
        for (int i = 0; i < n; i++) bent[i] = row.pull != 0 || (i && acts[i - 1]) || (i < n - 1 && acts[i]);
        for (int i = 0; i < n; i++) X[i][0] = x[i], X[i][1] = v[i];
        for (int j = 0; j < n - 1; j++) D[j][0] = d[j], D[j][1] = w[j];
        std::vector<int> acting, moving, changing;
        for (int i = 0; i < n; i++) {
            if (bent[i]) moving.push_back(i);
            if (i < n - 1 && acts[i]) acting.push_back(i);
            if (i < n - 1 && (bent[i] || bent[i + 1])) changing.push_back(i);
        }
        for (int k = 0; k < N - 1; k++) {
            for (int j : acting) F[j][k] = force(j, k);
            for (int i : moving) {
                Q push = (i && acts[i - 1] ? F[i - 1][k] : 0) - (i < n - 1 && acts[i] ? F[i][k] : 0);
                X[i][k + 2] = (push / row.m[i] - row.pull * X[i][k]) / ((k + 1) * (k + 2));
            }
            for (int j : changing)
                D[j][k + 2] = (bent[j] ? X[j][k + 2] : 0) - (bent[j + 1] ? X[j + 1][k + 2] : 0);
        }
        Q h = row.stop > 0 ? row.stop - t : FAR;
        for (int i : moving)
            for (int k = N - 4; k <= N; k++)  // some of them vanish
                if (X[i][k] != 0) h = std::min(h, powq(ERROR * row.speed / (k * fabsq(X[i][k])), Q(1) / (k - 1)));
        return h;
    }

    struct Switch { Q at; int j; Mode to; };

    void go() {
        for (long steps = 0;; steps++) {
            if (steps > 3000000) throw std::string("too many steps");
            bool apart = true;
            for (int j = 0; j < n - 1; j++) apart = apart && rests(row, j, mode[j] == open, d[j], w[j]);
            if (row.stop > 0 ? t >= row.stop : apart) break;
            Q h = series();
            std::vector<Switch> found;
            for (int j = 0; j < n - 1; j++) {
                auto look = [&](Poly poly, Q level, int sign, Mode to) {
                    Q at = first(poly, level, sign, h);
                    if (at < FAR) found.push_back({at, j, to});
                };
                Poly gap{D[j].data(), bent[j] || bent[j + 1] ? N : 1};
                if (mode[j] == open) {
                    if (gap.degree > 1 || w[j] > 0) look(gap, 0, 1, whole() ? pressing : faint);
                    continue;
                }
                if (d[j] != 0 || w[j] < 0) look(gap, 0, -1, open);
                if (mode[j] == faint && (gap.degree > 1 || w[j] > 0)) look(gap, least(j), 1, pressing);
                if (mode[j] == pressing && !whole() && w[j] < 0) look(gap, least(j) / 2, -1, faint);
                List sign(N - 1);  // of the force
                if (row.law == huntCrossley)
                    for (int k = 0; k < N - 1; k++) sign[k] = row.damping * (k + 1) * D[j][k + 1] + (k == 0);
                else if (row.law == viscoelastic)
                    for (int k = 0; k < N - 1; k++) sign[k] = D[j][k] + row.damping * row.p * (k + 1) * D[j][k + 1];
                else if (row.law == kelvinVoigtNoPull && mode[j] == clipped)
                    for (int k = 0; k < N - 1; k++) {
                        if (k == 0) power(j, 0);
                        sign[k] = row.k[j] * power(j, k) + row.damping * (k + 1) * D[j][k + 1];
                    }
                else if (row.law == kelvinVoigtNoPull)
                    sign = List(F[j].begin(), F[j].begin() + N - 1);
                else
                    continue;
                if (mode[j] == pressing) look({sign.data(), N - 2}, 0, -1, clipped);
                if (mode[j] == clipped) look({sign.data(), N - 2}, 0, 1, pressing);
            }
            for (auto& event : found) h = std::min(h, event.at);
            if (h >= FAR) break;  // the rest stays in touch, at rest
            move(h);
            for (auto& [at, j, to] : found) {
                if (at > h) continue;
                if (mode[j] == open) notes.closes(j, t), d[j] = 0;
                if (to == open) notes.opens(j, t), d[j] = 0;
                mode[j] = to;
            }
        }
        write(row, notes, x, v);
    }

    void move(Q h) {
        for (int j = 0; j < n - 1; j++) {
            if (acts[j]) {
                Poly f{F[j].data(), N - 2};
                notes.force(j, f(0)), notes.force(j, f(h));
                Q a = 0, b = h;
                if (f.slope(a) > 0 && f.slope(b) < 0) {
                    for (int i = 0; i < 60; i++) (f.slope((a + b) / 2) > 0 ? a : b) = (a + b) / 2;
                    notes.force(j, f(a));
                }
            }
            Poly gap{D[j].data(), bent[j] || bent[j + 1] ? N : 1};
            d[j] = gap(h), w[j] = gap.slope(h);
        }
        for (int i = 0; i < n; i++) {
            Poly path{X[i].data(), bent[i] ? N : 1};
            x[i] = path(h), v[i] = path.slope(h);
        }
        t += h;
    }
};

int main(int count, char** words) { return start<Taylor>(count, words); }
