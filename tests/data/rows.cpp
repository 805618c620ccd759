// Results for rows of balls on a line in quadruple precision, whose contacts have a constant restitution: rows.json.
//
//     g++ -O3 -std=gnu++17 tests/data/rows.cpp -lquadmath -o rows && ./rows > tests/data/rows.json
//
// Three to nine balls in touch, the first one or two lifted. How they are integrated is in arcs.hpp.
#include "arcs.hpp"

int main() {
    const Nodes many(22), fewer(18), few(12);
    const std::vector<double> MASSES = {1, 1.5, 0.75, 1.25, 2, 0.5, 1, 3, 0.875}, LOSSES = {1, 0, 2, 0.5, 3, 1, 1.5, 0};
    const struct { double p, k; } SPRINGS[] = {{1, 1e10}, {1.5, 1.925e10}, {2, 1e12}, {2.5, 1e14}, {3, 5e18}};
    const double RESTITUTIONS[] = {0.99, 0.9, 0.6, 0.1, 0.02};
    const char* comma = "[";
    int number = 0;
    for (int n = 3; n <= 9; n += 2)
        for (auto [p, k] : SPRINGS) {
            if (p == 1 && n > 5) continue;  // many linear contacts hardly part: too many switchings
            const double e = RESTITUTIONS[number % 5 == 0 ? number / 5 : (2 * number + n) % 5];
            const bool unequal = number % 2, lossy = number % 3 == 2;
            std::vector<double> x(n, 0.0);
            x[0] = -0.1;
            if (number % 4 == 3) x[1] = -0.1;
            Case given{x, constantRestitution, p, k, e, 0, {}, {}, 0, 0};
            if (unequal) given.masses.assign(MASSES.begin(), MASSES.begin() + n);
            if (lossy) given.losses.assign(LOSSES.begin(), LOSSES.begin() + n - 1);
            given.line = true;
            List exact(x.begin(), x.end()), near = exact;
            for (Q& value : near) value *= 1 + 1e-16Q;
            std::vector<Run> runs = {{given, many, 1e-18Q, exact}, {given, fewer, 1e-16Q, exact}};
            runs.emplace_back(given, few, 1e-12Q, near);
            printf("%s{\"law\": \"constantRestitution\", \"p\": %g, \"k\": %g, \"coefficient\": %g,\n "
                   "\"dead_band\": 0, \"drag\": 0, \"a_support\": 0, ", comma, p, k, e);
            show("start", x, ",\n "), show("masses", given.masses, ", "), show("losses", given.losses, ",\n \"states\": [");
            comma = "";
            const Q whole = runs[0].energy();
            for (double time : {0.8, 1.5}) {  // a moment after the first click, and before the second is over
                for (Run& run : runs) run.go(time);
                const double residual = double(runs[0].energy() / whole - 1);
                const double off = double(runs[1].off(runs[0]) / 0.1Q);
                const double sensitivity = std::max(1.0, double(runs[2].off(runs[0]) / 1e-17Q));
                fprintf(stderr, "%d: %d balls, p %g, e %g, %g s: %d steps, %d onsets, off by %.1e, energy %.1e, "
                        "sensitivity %.1e\n", number, n, p, e, time, runs[0].steps, runs[0].onsets, off, residual, sensitivity);
                if (!(off < 1e-18 * sensitivity && fabs(residual) < 1e-12)) return 1;
                Rows state = runs[0].state();
                printf("%s\n  {\"time\": %g, \"sensitivity\": %.2g,\n   ", comma, time, sensitivity);
                show("x", state[0], ",\n   "), show("v", state[1], "}");
                comma = ",";
            }
            printf("]}"), comma = ",\n";
            number++;
        }
    printf("]\n");
}
