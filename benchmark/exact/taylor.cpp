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

// The first time within (0, end] at which sign * (polynomial - level) becomes positive; later if it does not.
Q first(Poly poly, Q level, int sign, Q end) {
    auto above = [&](Q t) { return sign * (poly(t) - level) > 0; };
    if (poly.degree == 1) {
        Q start = sign * (poly.c[0] - level), rate = sign * poly.c[1];
        return start > 0 ? Q(0) : rate > 0 ? -start / rate : FAR;
    }
    for (int piece = 0; piece < 12; piece++) {
        Q a = end * piece / 12, b = end * (piece + 1) / 12;
        if (!above(b)) continue;
        if (above(a)) return a;
        for (int i = 0; i < 110; i++) (above((a + b) / 2) ? b : a) = (a + b) / 2;
        return b;
    }
    return FAR;
}

struct Taylor : Motion {
    std::vector<List> X, D, P, S, F;  // series: positions, overlaps, their power and square, forces

    Taylor(unsigned seed) : Motion(seed), X(n, List(N + 1)), D(X), P(X), S(X), F(X) {
        for (char& one : mode) one = one ? touched() : open;
    }
    Mode touched() const { return whole() ? pressing : faint; }
    bool viscous() const { return law == kelvinVoigt || law == kelvinVoigtNoPull; }
    bool acts(int j) const {
        return j >= 0 && j < n - 1 && (mode[j] == pressing || (mode[j] == faint && viscous()));
    }
    bool bent(int i) const { return pull != 0 || acts(i - 1) || acts(i); }  // other balls fly freely
    Poly path(int i) const { return {X[i].data(), bent(i) ? N : 1}; }
    Poly depth(int j) const { return {D[j].data(), bent(j) || bent(j + 1) ? N : 1}; }

    // The overlap below which a contact's elastic force is left out.
    Q least(int j) const {
        Q left_out = LEFT_OUT * mass * speed, slow = powq(left_out / (k[j] * time), 1 / p);
        Q fast = powq((p + 1) * fabsq(w[j]) * left_out / k[j], 1 / (p + 1));
        if (law == viscoelastic) fast = std::min(fast, powq(left_out / (k[j] * damping), 1 / p));
        return std::max(slow, fast);
    }

    // The coefficient of t^i of the overlap's power.
    Q power(int j, int i) {
        const List& c = D[j];
        Q sum = 0;
        if (p == 1) {
            sum = c[i];
        } else if (whole()) {
            for (int l = 0; l <= i; l++) sum += c[l] * c[i - l];
            S[j][i] = sum;
            for (int l = 0; p == 3 && l <= i; l++) sum = (l ? sum : 0) + S[j][l] * c[i - l];
        } else if (i == 0) {
            sum = powq(c[0], p);
        } else {
            for (int l = 1; l <= i; l++) sum += ((p + 1) * l - i) * c[l] * P[j][i - l];  // J. C. P. Miller
            sum /= i * c[0];
        }
        return P[j][i] = sum;
    }

    Q force(int j, int i) {
        Q spring = 0;
        if (mode[j] == pressing) {
            if (i == 0) power(j, 0);
            power(j, i + 1);
            spring = P[j][i];
            if (law == viscoelastic) spring += damping * (i + 1) * P[j][i + 1];
            for (int l = 0; law == huntCrossley && l <= i; l++) spring += damping * (l + 1) * D[j][l + 1] * P[j][i - l];
        }
        return k[j] * spring + (viscous() ? damping * (i + 1) * D[j][i + 1] : 0);
    }

    // A series that has the sign of the force, of laws that do not pull.
    List sign(int j) {
        List series(N - 1);
        for (int i = 0; i < N - 1; i++) {
            Q damped = damping * (i + 1) * D[j][i + 1];
            if (law == huntCrossley) series[i] = damped + (i == 0);
            if (law == viscoelastic) series[i] = D[j][i] + p * damped;
            if (law == kelvinVoigtNoPull) series[i] = k[j] * power(j, i) + damped;
        }
        return series;
    }

    // All series, and how far they hold.
    Q series() {
        std::vector<int> changing;  // balls that do not fly freely, or that follow one
        for (int i = 0; i < n; i++) {
            X[i][0] = x[i], X[i][1] = v[i], D[i][0] = d[i], D[i][1] = w[i];
            if (bent(i) || (i && bent(i - 1))) changing.push_back(i);
        }
        for (int k = 0; k < N - 1; k++)
            for (int i : changing) {
                if (acts(i)) F[i][k] = force(i, k);
                Q push = (acts(i - 1) ? F[i - 1][k] : 0) - (acts(i) ? F[i][k] : 0);
                if (bent(i)) X[i][k + 2] = (push / m[i] - pull * X[i][k]) / ((k + 1) * (k + 2));
                if (i) D[i - 1][k + 2] = (bent(i - 1) ? X[i - 1][k + 2] : 0) - (bent(i) ? X[i][k + 2] : 0);
            }
        Q h = stop > 0 ? stop - t : FAR;
        for (int i = 0; i < n; i++)
            for (int k = N - 4; bent(i) && k <= N; k++)  // some of them vanish
                if (X[i][k] != 0) h = std::min(h, powq(ERROR * speed / (k * fabsq(X[i][k])), Q(1) / (k - 1)));
        return h;
    }

    void go() {
        while (!over()) {
            Q h = series();
            struct Switch { Q at; int j; Mode to; };
            std::vector<Switch> found;
            for (int j = 0; j < n - 1; j++) {
                auto look = [&](Poly poly, Q level, int sign, Mode to) {
                    found.push_back({first(poly, level, sign, h), j, to});
                };
                bool free = depth(j).degree == 1, pulls = law <= kelvinVoigt;
                if (mode[j] == open && (!free || w[j] > 0)) look(depth(j), 0, 1, touched());
                if (mode[j] != open && (d[j] != 0 || w[j] < 0)) look(depth(j), 0, -1, open);
                if (mode[j] == faint && (!free || w[j] > 0)) look(depth(j), least(j), 1, pressing);
                if (mode[j] == pressing && !whole() && w[j] < 0) look(depth(j), least(j) / 2, -1, faint);
                if (mode[j] == pressing && !pulls) look({sign(j).data(), N - 2}, 0, -1, clipped);
                if (mode[j] == clipped) look({sign(j).data(), N - 2}, 0, 1, pressing);
            }
            for (auto& event : found) h = std::min(h, event.at);
            if (h >= FAR) break;  // the rest stays in touch, at rest
            move(h);
            for (auto& [at, j, to] : found)
                if (at <= h) turn(j, to);
        }
        write();
    }

    void move(Q h) {
        for (int j = 0; j < n - 1; j++) {
            if (acts(j)) {
                Poly f{F[j].data(), N - 2};
                Q a = 0, b = h;
                for (int i = 0; f.slope(0) > 0 && f.slope(h) < 0 && i < 60; i++)
                    (f.slope((a + b) / 2) > 0 ? a : b) = (a + b) / 2;
                peak[j] = std::max({peak[j], f(0), f(h), f(a)});
            }
            d[j] = depth(j)(h), w[j] = depth(j).slope(h);
        }
        for (int i = 0; i < n; i++) x[i] = path(i)(h), v[i] = path(i).slope(h);
        t += h;
    }
};

int main(int, char** words) { Taylor(atoi(words[1])).go(); }
