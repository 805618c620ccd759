// A row of balls by extrapolation of the modified midpoint rule (Gragg, Bulirsch and Stoer), in quadruple precision.
// A step ends where a contact closes or opens: its length is solved for. Where else a force is not smooth, such as a
// power of 3/2 at overlap 0 or one that reaches 0, steps shrink until the extrapolation converges.
#include "row.hpp"

const int COLUMNS = 14;
const Q TOLERANCE = 1e-24Q, NOISE = 1e-22Q;  // of the speed

struct Gragg : Motion {
    List end, rate, before, now;  // like y; `end`: of the step that was tried last
    std::vector<List> table;
    int low = 0, high = -1;   // the balls that do not fly freely
    std::vector<int> moving;  // their elements of y

    Gragg(unsigned seed) : Motion(seed), rate(4 * n), before(rate), now(rate), table(COLUMNS, rate) {}

    // A power of 1/2, 1, 3/2 and so on.
    static Q power(Q base, Q exponent) {
        Q product = 1;
        for (; exponent >= 1; exponent -= 1) product *= base;
        return exponent > 0 ? product * sqrtq(base) : product;
    }

    Q force(int j, const List& at) const {
        if (!mode[j]) return 0;
        Q deep = whole() ? at[2 * n + j] : std::max(at[2 * n + j], Q(0)), change = at[3 * n + j];
        Q f = k[j] * power(deep, p);
        if (law == huntCrossley) f *= 1 + damping * change;
        else if (law == viscoelastic) f += damping * k[j] * p * power(deep, p - 1) * change;
        else if (law != elastic) f += damping * change;
        return law > kelvinVoigt ? std::max(f, Q(0)) : f;
    }

    void rates(const List& at) {
        Q left = 0;
        for (int i = low; i <= high; i++) {
            Q right = i < high ? force(i, at) : 0;
            rate[i] = at[n + i], rate[n + i] = (left - right) / m[i] - pull * at[i], left = right;
        }
        for (int j = std::max(low - 1, 0); j <= std::min(high, n - 2); j++) {
            rate[2 * n + j] = at[3 * n + j];
            rate[3 * n + j] = (j < low ? 0 : rate[n + j]) - (j < high ? rate[n + j + 1] : 0);
        }
    }

    // All between the first and the last closed contact move as one system; pendulums do always. Returns the longest
    // step: where the motion is linear, an extrapolation that converges could hide a contact that turns twice.
    Q window() {
        low = n, high = -1, moving.clear();
        for (int j = 0; j < n - 1; j++)
            if (mode[j]) low = std::min(low, j), high = j + 1;
        Q longest = low < high && p == 1 ? time / 2 : pull != 0 ? 0.5Q / sqrtq(pull) : 1e4000Q;
        if (pull != 0) low = 0, high = n - 1;
        for (int i = low; i <= high; i++) moving.push_back(i), moving.push_back(n + i);
        for (int j = std::max(low - 1, 0); j <= std::min(high, n - 2); j++)
            moving.push_back(2 * n + j), moving.push_back(3 * n + j);
        return longest;
    }

    // One step of length h, to `end`: the columns until it converges, or 0.
    int attempt(Q h) {
        Q worst = 0;
        end = y;
        for (int i = 0; i < n; i++) end[i] += h * v[i], end[2 * n + i] += h * w[i];
        for (int k = 0; k < COLUMNS; k++) {
            const int steps = 2 * (k + 1);
            Q step = h / steps, last = std::exchange(worst, 0);
            rates(y);
            for (int i : moving) before[i] = y[i], now[i] = y[i] + step * rate[i];
            for (int s = 1; s < steps; s++) {
                rates(now);
                for (int i : moving) std::swap(before[i], now[i]), now[i] += 2 * step * rate[i];
            }
            rates(now);
            for (int i : moving) {
                Q value = (before[i] + now[i] + step * rate[i]) / 2;
                for (int c = 0; c < k; c++) {
                    Q ratio = Q(k + 1) / (k - c), old = table[c][i];
                    table[c][i] = value, value += (value - old) / (ratio * ratio - 1);
                }
                table[k][i] = value;
                if (i / n % 2) worst = std::max(worst, fabsq(value - end[i]));
                end[i] = value;
            }
            if (k > 2 && worst < TOLERANCE * speed) return k;
            if (k > 4 && worst > 0.3Q * last) return 0;
        }
        return moving.empty();
    }

    bool turns(int j) const {
        return mode[j] ? end[2 * n + j] < 0 && end[3 * n + j] < -NOISE * speed : end[2 * n + j] > 0;
    }

    // Shortens a step to the first contact that turns in it, by Newton's method; returns that, or -1.
    int shorten(Q& h) {
        int first = -1;
        for (int tries = 0; tries < 100; tries++) {
            auto late = [&](int j) { return end[2 * n + j] / end[3 * n + j]; };
            Q most = first < 0 ? 0 : late(first);
            for (int j = 0; j < n - 1; j++)
                if (turns(j) && (first < 0 || late(j) > most)) first = j, most = late(j);
            if (fabsq(most) <= 1e-31Q * (t + h)) return first;
            h -= most < h ? most : h / 2, attempt(h);
        }
        throw std::runtime_error("a contact does not turn");
    }

    // How much the force grows in a moment.
    Q growth(int j, const List& at) {
        rates(at);
        for (int i : {2 * n + j, 3 * n + j}) now[i] = at[i] + 1e-14Q * time * rate[i];
        return force(j, now) - force(j, at);
    }

    // Notes the forces in a step of length h, to `end`, and where they have a maximum.
    void peaks(Q h) {
        const List last = end;
        for (int j = low; j < high; j++) {
            Q a = 0, b = growth(j, y) > 0 && growth(j, last) < 0 ? h : 0;
            for (int i = 0; b > 0 && i < 50; i++) {
                attempt((a + b) / 2);
                (growth(j, end) > 0 ? a : b) = (a + b) / 2;
            }
            peak[j] = std::max({peak[j], force(j, y), force(j, end), force(j, last)});
            end = last;
        }
    }

    void go() {
        Q h = time / 10;
        while (!over()) {
            h = std::min(h, window());
            if (stop > 0) h = std::min(h, stop - t);
            int columns = attempt(h);
            if (columns) {
                Q length = h;
                int first = shorten(length);
                peaks(length);
                std::copy(end.begin(), end.end(), y.begin()), t += length;
                for (int j = 0; j < n - 1; j++)
                    if (j == first || turns(j)) turn(j, !mode[j]);
            }
            h *= columns == 0 ? 0.4Q : columns < COLUMNS - 3 ? 2 : 1;
        }
        write();
    }
};

int main(int, char** words) { Gragg(atoi(words[1])).go(); }
