// Results for balls on arcs in quadruple precision: arcs.json.
//
//     g++ -O3 -std=gnu++17 tests/data/arcs.cpp -lquadmath -o arcs && ./arcs > tests/data/arcs.json
//
// Two to five balls, lifted: one of each kind. How they are integrated is in arcs.hpp.
#include "arcs.hpp"

const double STEEL = 1.925e10, FIGURE6 = 2.9e14;
const std::vector<double> UNEQUAL = {1, 1.25, 0.875, 1.125, 1}, MASSES = {1, 1.5, 0.75, 1.25, 2};
const Case CASES[] = {
    {{-10, 0}, elastic, 1, FIGURE6, 0, 1.46e-7, {}, {}, 0, 0},
    {{-30, -30, 0, 0, 0}, elastic, 1, FIGURE6, 0, 1.46e-7, {}, {}, 0, 0},
    {{-60, -60, 0, 0, 0}, elastic, 1, FIGURE6, 0, 1.46e-7, {}, {}, 0, 0},
    {{-80, 0, 0, 0}, elastic, 1, 1e10, 0, 0, {}, {}, 0, 0},
    {{-30, 0, 0}, elastic, 1, 1e10, 0, 0, {1, 1.25, 0.875}, {1, 1.5, 0.75}, 0, 0},
    {{-10, 0, 0}, elastic, 1.5, STEEL, 0, 0, {}, {}, 0, 0},
    {{-30, -30, 0, 0, 0}, elastic, 1.5, STEEL, 0, 0, {}, {}, 0, 0},
    {{-60, -60, 0, 0, 0}, elastic, 1.5, STEEL, 0, 2.6e-5, {}, {}, 0, 0},
    {{-80, 0, 0, 0, 30}, elastic, 1.5, STEEL, 0, 0, {}, {}, 0, 0},
    {{-80, 0}, elastic, 1.5, STEEL, 0, 2.6e-5, {1, 1.25}, {}, 0, 0},
    {{-30, -30, 0, 0, 0}, elastic, 1.5, STEEL, 0, 2.6e-5, UNEQUAL, MASSES, 0, 0},
    {{-30, 0, 0}, kelvinVoigt, 1, 1e10, 2000, 2.6e-5, {}, {}, 0, 0.5},
    {{-80, 0, 0, 0}, kelvinVoigtNoPull, 1, 1e10, 2000, 2.6e-5, {1, 1.25, 0.875, 1.125}, {}, 0, 0},
    {{-10, 0, 0, 0, 0}, huntCrossley, 1.5, STEEL, 0.03, 0, {}, {}, 0.01, 0},
    {{-45, -45, 0, 0, 0}, huntCrossley, 1.5, STEEL, 0.01, 2.6e-5, UNEQUAL, MASSES, 0.01, 0},
    {{-30, -30, 0, 0, 0}, viscoelastic, 1.5, STEEL, 4e-7, 0, {}, {}, 0, 0},
    {{-45, 0, 0}, viscoelastic, 1.5, STEEL, 4e-7, 2.6e-5, {1, 1.25, 0.875}, {1, 1.5, 0.75}, 0, 0},
    {{-30, 0, 0}, constantRestitution, 1.5, STEEL, 0.95, 0, {}, {1, 1.5, 0.75}, 0, 0},
    {{-45, 0, 0}, constantRestitution, 1.5, STEEL, 0.5, 2.6e-5, {1, 1.25, 0.875}, {}, 0.01, 0, {}, {}, {1, 0}},
    {{-60, 0}, rigid, 1, 0, 1, 0, {}, {1, 1.7}, 0, 0},
    {{-60, 0}, rigid, 1, 0, 0.9, 0, {1, 0.8}, {1, 1.7}, 0, 0, {0.02}},
    {{-60, 0, 0}, rigid, 1, 0, 0.9, 0, {}, {1, 1.7, 0.6}, 0, 0},
    {{-60, 0, 0}, rigid, 1, 0, 1, 0, {1, 0.8, 0.9}, {1, 1.7, 0.6}, 0, 0, {0.02, 0.01}},
};

double start(double degrees) { return double(LENGTH * sinq(degrees * M_PIq / 180)); }
Q period(Q x) {  // of a pendulum, by the arithmetic-geometric mean
    Q a = 1, b = sqrtq((1 + sqrtq(1 - x * x / (LENGTH * LENGTH))) / 2);
    for (int i = 0; i < 9; i++) std::tie(a, b) = std::pair((a + b) / 2, sqrtq(a * b));
    return 2 * M_PIq * sqrtq(LENGTH / GRAVITY) / a;
}

int main(int count, char** words) {
    const Nodes many(22), fewer(18), few(12);
    std::vector<double> x;
    List periods;
    for (double degrees : {1., 30., 80., 89.9}) x.push_back(start(degrees)), periods.push_back(period(x.back()));
    printf("{\n \"radius\": %.17g, \"length\": 1.962,\n ", double(RADIUS));
    show("amplitudes", x, ",\n "), show("periods", periods, ",\n \"cradles\": [");
    const char* comma = "";
    for (const Case& given : CASES) {
        if (count > 1 && &given - CASES != atoi(words[1])) continue;
        std::vector<double> x;
        for (double degrees : given.degrees) x.push_back(start(degrees));
        const Q amplitude = -x[0];
        List exact(x.begin(), x.end());
        std::vector<Run> runs = {{given, many, 1e-18Q, exact}, {given, fewer, 1e-16Q, exact}};
        List near = exact;
        for (Q& value : near) value *= 1 + 1e-16Q;
        runs.emplace_back(given, few, 1e-12Q, near);
        printf("%s\n  {\"law\": \"%s\", \"p\": %g, \"k\": %.17g, \"coefficient\": %g, \"dead_band\": %g, \"drag\": %g, "
               "\"a_support\": %g,\n   ", comma, LAWS[given.law], given.p, given.k, given.coefficient, given.deadBand,
               given.drag, given.support);
        show("start", x, ",\n   "), show("lengths", given.lengths, ", ");
        show("masses", given.masses, ", "), show("losses", given.losses, ", ");
        show("gaps", given.gaps, ",\n   \"states\": [");
        comma = "";
        const Q whole = runs[0].energy();
        for (int halves : {1, 10}) {  // periods of the first ball: after as many clicks
            const double time = double(rintq(period(amplitude) / 2 * halves * 1024) / 1024);
            for (Run& run : runs) run.go(time);
            const double residual = double(runs[0].energy() / whole - 1);
            const double off = double(runs[1].off(runs[0]) / amplitude);
            const double sensitivity = std::max(1.0, double(runs[2].off(runs[0]) / (1e-16Q * amplitude)));
            fprintf(stderr, "%d, %g s: %d steps, %d onsets, off by %.1e, energy %.1e, sensitivity %.1e\n",
                    int(&given - CASES), time, runs[0].steps, runs[0].onsets, off, residual, sensitivity);
            if (!(off < 1e-18 * sensitivity && fabs(residual) < 1e-14)) return 1;
            Rows state = runs[0].state();
            printf("%s\n    {\"time\": %.17g, \"sensitivity\": %.2g,\n     ", comma, time, sensitivity);
            show("x", state[0], ",\n     "), show("v", state[1], ",\n     "), show("angle", state[2], "}");
            comma = ",";
        }
        printf("]}");
    }
    printf("\n ]\n}\n");
}
