// A row of balls by extrapolation of the modified midpoint rule (Gragg, Bulirsch and Stoer), in quadruple precision.
// A step ends where a contact closes or opens: its length is solved for. Where else a force is not smooth, such as a
// power of 3/2 at overlap 0 or one that reaches 0, steps shrink until the extrapolation converges.
#include "row.hpp"

const int COLUMNS = 14;
const Q TOLERANCE = 1e-24Q, NOISE = 1e-22Q;  // of the speed

struct Gragg : Motion {
    List end;                  // like y, of the step that was tried last
    int low, high, count;      // the first and the last ball of the system that moves as one, and how many
    std::gslice part, speeds;  // of y; of that part

    Gragg(unsigned seed) : Motion(seed) {}

    // A power of a number, fast for 1/2, 1, 3/2 and so on.
    static Q power(Q base, Q exponent) {
        Q product = 1;
        for (; exponent >= 1; exponent -= 1) product *= base;
        return exponent == 0.5Q ? product * sqrtq(base) : exponent > 0 ? product * powq(base, exponent) : product;
    }

    Q force(int j, const List& at) const {
        if (!mode[j]) return 0;
        Q overlap = at[2 * count + j - low], change = at[3 * count + j - low];
        Q deep = whole() ? overlap : std::max(overlap, Q(0)), f = k[j] * power(deep, p);
        if (law == huntCrossley) f *= 1 + damping * change;
        else if (law == viscoelastic) f += damping * k[j] * p * power(deep, p - 1) * change;
        else if (law == constantRestitution) f += c[j] * power(deep, root) * change;
        else if (law != elastic) f += damping * change;
        return law > kelvinVoigt ? std::max(f, Q(0)) : f;
    }

    List rates(const List& at) const {
        List rate(4 * count);
        Q left = 0;
        for (int i = 0; i < count; i++) {
            Q right = force(low + i, at), push = (left - right) / m[low + i] - pull * at[i];
            rate[i] = at[count + i], rate[count + i] = push, left = right;
            if (i) rate[3 * count + i - 1] -= push;
            if (low + i < n - 1) rate[2 * count + i] = at[3 * count + i], rate[3 * count + i] = push;
        }
        return rate;
    }

    // All from the ball before the first closed contact to the last one move as one system; pendulums do always.
    // Returns the longest step: where the motion is linear, an extrapolation that converges could hide a contact that
    // turns twice.
    Q window() {
        low = n, high = -1;
        for (int j = 0; j < n - 1; j++)
            if (mode[j]) low = std::min(low, j), high = j + 1;
        Q longest = low < high && p == 1 ? time / 2 : pull != 0 ? 0.5Q / sqrtq(pull) : HUGE_VALQ;
        low = pull != 0 ? 0 : std::max(low - 1, 0), high = pull != 0 ? n - 1 : high;
        count = std::max(high - low + 1, 0);
        size_t width = count, length = n;
        part = {size_t(low), {4, width}, {length, 1}}, speeds = {width, {2, width}, {2 * width, 1}};
        return longest;
    }

    // One step of length h, to `end`: the columns until it converges, or 0.
    int attempt(Q h) {
        end = y;
        for (int i = 0; i < n; i++) end[i] += h * v[i], end[2 * n + i] += h * w[i];
        if (!count) return 1;
        const List start = y[part];
        List table[COLUMNS];
        Q worst = 0;
        for (int k = 0; k < COLUMNS; k++) {
            const int steps = 2 * (k + 1);
            Q step = h / steps, last = worst;
            List before = start, now = start + step * rates(start);
            for (int s = 1; s < steps; s++) before += 2 * step * rates(now), before.swap(now);
            List value = (before + now + step * rates(now)) / Q(2);
            for (int c = 0; c < k; c++) {
                Q ratio = Q(k + 1) / (k - c);
                const List old = std::exchange(table[c], value);
                value += (value - old) / (ratio * ratio - 1);
            }
            table[k] = value;
            List change = abs(value - List(end[part]));
            end[part] = value, worst = List(change[speeds]).max();
            if (k > 2 && worst < TOLERANCE * speed) return k;
            if (k > 4 && worst > 0.3Q * last) return 0;
        }
        return 0;
    }

    bool turns(int j) const {
        return mode[j] ? end[2 * n + j] < 0 && end[3 * n + j] < -NOISE * speed : end[2 * n + j] > 0;
    }

    // Shortens a step to the first contact that turns in it, by Newton's method; returns that, or -1.
    int shorten(Q& h) {
        auto late = [&](int j) { return end[2 * n + j] / end[3 * n + j]; };
        for (int first = -1;;) {
            for (int j = 0; j < n - 1; j++)
                if (turns(j) && (first < 0 || late(j) > late(first))) first = j;
            Q most = first < 0 ? 0 : late(first);
            if (fabsq(most) <= 1e-31Q * (t + h)) return first;
            h -= most < h ? most : h / 2, attempt(h);
        }
    }

    // How much the force grows in a moment.
    Q growth(int j, const List& at) const { return force(j, at + 1e-14Q * time * rates(at)) - force(j, at); }

    // Notes the forces in a step of length h, to `end`, and where they have a maximum.
    void peaks(Q h) {
        const List last = end;
        for (int j = low; j < high; j++) {
            Q a = 0, b = growth(j, y[part]) > 0 && growth(j, end[part]) < 0 ? h : 0;
            for (int i = 0; b > 0 && i < 50; i++) {
                attempt((a + b) / 2);
                (growth(j, end[part]) > 0 ? a : b) = (a + b) / 2;
            }
            peak[j] = std::max({peak[j], force(j, y[part]), force(j, end[part]), force(j, last[part])});
            end = last;
        }
    }

    void go() {
        Q h = time / 10;
        while (!over()) {
            h = std::min(h, window());
            Q length = std::min(h, stop - t);
            int columns = attempt(length);
            if (columns) {
                int first = shorten(length);
                peaks(length);
                y = end, t += length;
                for (int j = 0; j < n - 1; j++)
                    if (j == first || turns(j)) turn(j, !mode[j]);
            }
            h *= columns == 0 ? 0.4Q : columns < COLUMNS - 3 ? 2 : 1;
        }
        write();
    }
};

int main(int, char** words) { Gragg(atoi(words[1])).go(); }
