// A row of balls by Taylor series of its whole motion, in quadruple precision. A step ends where a contact switches.
// A force that is no whole power of the overlap has no series at overlap 0: steps shrink towards it and grow from it,
// and forces whose impulse is below 1e-32 of the row's are left out ("faint"). They are left out until a row in touch
// feels them, too. Overlaps are carried on by themselves: no digits are lost where they are small.
#include "row.hpp"

enum Mode { open, faint, pressing, clipped };
const int N = 36;
const Q LEFT_OUT = 1e-32Q, ERROR = 1e-25Q;

// The value of a series of this degree, or of its derivative.
Q value(Q t, const List& c, int degree, bool slope = false) {
    Q sum = 0;
    for (int k = degree; k >= slope; k--) sum = sum * t + (slope ? k * c[k] : c[k]);
    return sum;
}

// The coefficient of t^i of a product of series.
Q product(const List& a, const List& b, int i) {
    Q sum = 0;
    for (int l = 0; l <= i; l++) sum += a[l] * b[i - l];
    return sum;
}

// The first time within (0, end] at which a condition holds; infinity if it does not.
template <class Condition>
Q first(Q end, Condition holds) {
    for (int piece = 0; piece < 12; piece++) {
        Q a = end * piece / 12, b = end * (piece + 1) / 12;
        if (!holds(b)) continue;
        if (holds(a)) return a;
        for (int i = 0; i < 110; i++) (holds((a + b) / 2) ? b : a) = (a + b) / 2;
        return b;
    }
    return HUGE_VALQ;
}

struct Taylor : Motion {
    std::vector<List> X, D, W, P, R, S, F;  // series: positions, overlaps, their rate, powers and square, forces

    Taylor(unsigned seed) : Motion(seed), X(n, List(N + 1)), D(X), W(X), P(X), R(X), S(X), F(X) {
        for (char& one : mode) one = one ? touched() : open;
    }
    Mode touched() const { return whole() ? pressing : faint; }
    bool viscous() const { return law == kelvinVoigt || law == kelvinVoigtNoPull || (p == 1 && law == constantRestitution); }
    Q dashpot(int j) const { return law == constantRestitution ? c[j] : damping; }
    bool acts(int j) const {
        return j >= 0 && j < n - 1 && (mode[j] == pressing || (mode[j] == faint && viscous()));
    }
    bool bent(int i) const { return pull != 0 || acts(i - 1) || acts(i); }  // other balls fly freely
    Q position(int i, Q t, bool slope = false) const { return value(t, X[i], bent(i) ? N : 1, slope); }
    Q overlap(int j, Q t, bool slope = false) const { return value(t, D[j], bent(j) || bent(j + 1) ? N : 1, slope); }

    // The overlap below which a contact's elastic force is left out.
    Q least(int j) const {
        Q left_out = LEFT_OUT * mass * speed, slow = powq(left_out / (k[j] * time), 1 / p);
        Q fast = powq((p + 1) * fabsq(w[j]) * left_out / k[j], 1 / (p + 1));
        if (law == viscoelastic) fast = std::min(fast, powq(left_out / (k[j] * damping), 1 / p));
        if (law == constantRestitution) fast = std::min(fast, powq((root + 1) * left_out / c[j], 1 / (root + 1)));
        return std::max(slow, fast);
    }

    // The coefficient of t^i of a power of the overlap, with this series.
    Q power(int j, Q q, const List& series, int i) {
        const List& c = D[j];
        if (q == 1) return c[i];
        if (q == 2) return product(c, c, i);
        if (q == 3) return S[j][i] = product(c, c, i), product(S[j], c, i);
        if (i == 0) return powq(c[0], q);
        Q sum = 0;
        for (int l = 1; l <= i; l++) sum += ((q + 1) * l - i) * c[l] * series[i - l];  // J. C. P. Miller
        return sum / (i * c[0]);
    }

    Q force(int j, int i) {
        W[j][i] = (i + 1) * D[j][i + 1];
        Q spring = 0;
        if (mode[j] == pressing) {
            if (i == 0) P[j][0] = power(j, p, P[j], 0);
            P[j][i + 1] = power(j, p, P[j], i + 1);
            spring = P[j][i];
            if (law == viscoelastic) spring += damping * (i + 1) * P[j][i + 1];
            if (law == huntCrossley) spring += damping * product(W[j], P[j], i);
        }
        Q damped = viscous() ? dashpot(j) * W[j][i] : 0;
        if (law == constantRestitution && !viscous() && mode[j] == pressing) {
            if (i == 0) R[j][0] = power(j, root + 1, R[j], 0);
            R[j][i + 1] = power(j, root + 1, R[j], i + 1);
            damped = c[j] / (root + 1) * (i + 1) * R[j][i + 1];
        }
        return k[j] * spring + damped;
    }

    // Has the sign of the force, of laws that do not pull.
    Q sign(int j, Q t) const {
        Q deep = overlap(j, t), damped = damping * overlap(j, t, true);
        if (law == huntCrossley) return 1 + damped;
        if (law == constantRestitution) return k[j] * powq(std::max(deep, Q(0)), root + 1) + c[j] * overlap(j, t, true);
        return law == viscoelastic ? deep + p * damped : k[j] * powq(deep, p) + damped;
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
        Q h = stop - t;
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
                bool free = !bent(j) && !bent(j + 1), nearing = !free || w[j] > 0;
                auto look = [&](auto condition, Mode to) { found.push_back({first(h, condition), j, to}); };
                auto passes = [&](Q level, int way, Mode to) {  // the overlap, upwards or downwards
                    Q distance = way * (level - d[j]), rate = way * w[j];
                    if (!free) look([&](Q t) { return way * (overlap(j, t) - level) > 0; }, to);
                    else if (distance < 0 || rate > 0) found.push_back({distance > 0 ? distance / rate : 0, j, to});
                };
                if (mode[j] == open && nearing) passes(0, 1, touched());
                if (mode[j] != open && (d[j] != 0 || w[j] < 0)) passes(0, -1, open);
                if (mode[j] == faint && nearing) passes(least(j), 1, pressing);
                if (mode[j] == pressing && !whole() && w[j] < 0) passes(least(j) / 2, -1, faint);
                if (law <= kelvinVoigt) continue;  // it may pull
                if (mode[j] == pressing) look([&](Q t) { return sign(j, t) < 0; }, clipped);
                if (mode[j] == clipped) look([&](Q t) { return sign(j, t) > 0; }, pressing);
            }
            for (auto& event : found) h = std::min(h, event.at);
            move(h);
            for (auto& [at, j, to] : found)
                if (at <= h) turn(j, to);
        }
        write();
    }

    void move(Q h) {
        for (int j = 0; j < n - 1; j++) {
            if (acts(j)) {
                Q top = std::min(h, first(h, [&](Q t) { return value(t, F[j], N - 2, true) < 0; }));
                for (Q t : {Q(0), top, h}) peak[j] = std::max(peak[j], value(t, F[j], N - 2));
            }
            d[j] = overlap(j, h), w[j] = overlap(j, h, true);
        }
        for (int i = 0; i < n; i++) x[i] = position(i, h), v[i] = position(i, h, true);
        t += h;
    }
};

int main(int, char** words) { Taylor(atoi(words[1])).go(); }
