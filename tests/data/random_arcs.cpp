// Results for random balls on arcs in quadruple precision: random_arcs.json.
//
//     g++ -O3 -std=gnu++17 tests/data/random_arcs.cpp -lquadmath -o random_arcs
//     ./random_arcs 0 263 > tests/data/random_arcs.json
//
// Cradles 0 to 262, each a line by itself, by seeds of their own: two to five balls with all laws in turn, equal and
// unequal, side by side or apart, at rest or not, with drag and constant inputs or without. How they are integrated is
// in arcs.hpp. A cradle that comes to what strings do not allow `ends` so, before a `time`. One whose results are not
// as exact as they should be, or would take long, is left out; why goes to stderr.
#include "arcs.hpp"

#include <random>

struct Random {
    std::mt19937_64 bits;
    double between(double a, double b) { return a + (b - a) * double(bits() >> 11) * 0x1p-53; }
    double scale(double a, double b) { return a * std::pow(b / a, between(0, 1)); }
    int below(int n) { return int(bits() % n); }
    bool maybe() { return bits() % 2; }
    // Four digits of a number, so that what is written is what was computed.
    static double brief(double value) {
        char text[32];
        snprintf(text, sizeof text, "%.4g", value);
        return atof(text);
    }
};

struct Cradle {
    Case given;
    std::vector<double> x, v;
    double amplitude = 0, times[2];
};

// One that may start like this or not.
Cradle drawn(int number, Random& random) {
    auto list = [&](int count, auto value) {
        std::vector<double> values;
        for (int i = 0; i < count; i++) values.push_back(random.brief(value(i)));
        return values;
    };
    const double exponents[] = {1, 1.25, 1.5, 1.5, 1.5, 1.75, 2, 2.5, 3};
    const double length = double(LENGTH), gravity = double(GRAVITY), lift = random.scale(4, 70) * M_PI / 180;
    const int n = 2 + random.below(random.maybe() ? 4 : 2), kind = random.below(3), left = 1 + random.below(n - 1);
    const int right = kind == 1 ? random.below(n - left + 1) : 0;
    const double speed = 2 * sqrt(gravity * length) * sin(lift / 2), other = random.between(0.3, 1) * lift;
    Cradle cradle;
    Case& c = cradle.given;
    c.law = Law(number % rigid);
    c.p = exponents[random.below(9)];
    if (c.law <= kelvinVoigtNoPull && random.maybe()) c.p = 1;
    if (random.maybe()) c.lengths = list(n, [&](int) { return random.scale(0.7, 1.4); });
    if (random.maybe()) c.masses = list(n, [&](int) { return random.scale(0.3, 3); });
    // A pair that meets at `speed` reaches this overlap.
    const double reach = random.scale(1e-6, 3e-3), mass = 0.5;
    c.k = random.brief(0.5 * (c.p + 1) * mass * speed * speed / pow(reach, c.p + 1));
    const double slope = c.p * c.k * pow(reach, c.p - 1), share = random.scale(0.01, 0.5);
    c.coefficient = c.law == elastic ? 0 : random.brief(
        c.law <= kelvinVoigtNoPull ? 2 * share * sqrt(slope * mass) :
        c.law == huntCrossley ? 1.5 * share / speed : share * reach / speed);
    c.deadBand = random.maybe() ? random.brief(random.scale(1e-7, 1e-3)) : 0;
    c.drag = random.maybe() ? random.brief(random.scale(1e-3, 0.5)) : 0;
    c.support = random.maybe() ? random.brief(random.between(-1, 1)) : 0;
    if (random.maybe()) c.forces = list(n, [&](int) { return random.between(-1, 1); });
    if (kind < 2) {  // rows of balls, lifted on the left, or on both sides
        const double angles[] = {-lift, 0, other};
        cradle.x = list(n, [&](int i) { return length * sin(angles[i < left ? 0 : i < n - right ? 1 : 2]); });
        cradle.v = std::vector<double>(n, 0);
    } else {  // balls apart, all of them in motion
        c.gaps = list(n - 1, [&](int) { return random.between(0, 0.06); });
        double angle = -lift;
        cradle.x = list(n, [&](int i) {
            const double at = angle;
            angle += random.between(0.1, 1) * 2 * lift / n;
            return length * (c.lengths.empty() ? 1 : c.lengths[i]) * sin(at);
        });
        cradle.v = list(n, [&](int) { return random.between(-0.5, 0.5) * speed; });
    }
    for (double x : cradle.x) cradle.amplitude = std::max(cradle.amplitude, fabs(x));
    const double half = M_PI * sqrt(length / gravity);
    cradle.times[0] = random.brief(half * random.between(0.7, 1.3));
    cradle.times[1] = random.brief(half * random.between(1.6, 2.6));
    return cradle;
}

Cradle cradle(int number) {
    Random random{std::mt19937_64(1000 + number)};
    while (true) {
        Cradle cradle = drawn(number, random);
        const Nodes none(1);
        const Run run(cradle.given, none, 0, {cradle.x.begin(), cradle.x.end()}, {cradle.v.begin(), cradle.v.end()});
        bool starts = true;
        for (Q angle : run.now.angle) starts = starts && fabsq(angle) < 1.3Q;
        for (int j = 0; starts && j < run.n - 1; j++) {
            const auto of = run.contact(j, run.now);
            starts = of.d < NOISE;
            for (int i : {j, j + 1}) {
                const Q angle = run.now.angle[i];
                starts = starts && of.x * cosq(angle) + of.y * sinq(angle) > 0.2Q;
            }
        }
        if (starts) return cradle;
    }
}

// The results of a cradle, as a line.
void follow(int number, const Nodes& many, const Nodes& fewer, const Nodes& few) {
    const Cradle start = cradle(number);
    const Case& c = start.given;
    const int n = int(start.x.size());
    Random random{std::mt19937_64(number)};
    List x(start.x.begin(), start.x.end()), v(start.v.begin(), start.v.end()), near = x, beside = v;
    const Q small = 1e-16Q * start.amplitude;
    for (int i = 0; i < n; i++)
        near[i] += random.between(-1, 1) * small, beside[i] += random.between(-1, 1) * small * sqrtq(GRAVITY / LENGTH);
    Run runs[] = {{c, many, 1e-18Q, x, v}, {c, fewer, 1e-16Q, x, v}, {c, few, 1e-12Q, near, beside}};
    for (Run& run : runs) run.most = 400;
    const Q whole = runs[0].energy();
    const char* comma = "";
    std::string states, ends;
    char text[256];
    for (double time : start.times) {
        try {
            for (Run& run : runs) run.go(time);
        } catch (const std::runtime_error& error) {
            ends = error.what();
            if (ends == "too many steps") break;
            snprintf(text, sizeof text, "%s{\"time\": %.17g, \"ends\": \"%s\"}", comma, time, error.what());
            states += text;
            break;
        }
        const double residual = double(runs[0].energy() / whole - 1);
        const double off = double(runs[1].off(runs[0]) / start.amplitude);
        const double sensitivity = std::max(1.0, double(runs[2].off(runs[0]) / small));
        fprintf(stderr, "%d, %g s: %d steps, %d onsets, off by %.1e, energy %.1e, sensitivity %.1e\n", number, time,
                runs[0].steps, runs[0].onsets, off, residual, sensitivity);
        if (!(off < 1e-18 * sensitivity && fabs(residual) < 1e-15)) {
            fprintf(stderr, "%d: left out\n", number);
            return;
        }
        snprintf(text, sizeof text, "%s{\"time\": %.17g, \"sensitivity\": %.2g, \"onsets\": %d, ", comma, time,
                 sensitivity, runs[0].onsets);
        const Rows state = runs[0].state();
        states += text + shown("x", state[0], ", ") + shown("v", state[1], ", ") + shown("angle", state[2], "}");
        comma = ", ";
    }
    if (!ends.empty()) fprintf(stderr, "%d: %s\n", number, ends.c_str());
    if (states.empty()) return;
    printf("{\"number\": %d, \"law\": \"%s\", \"p\": %g, \"k\": %.17g, \"coefficient\": %.17g, \"dead_band\": %.17g, "
           "\"drag\": %.17g, \"a_support\": %.17g, ",
           number, LAWS[c.law], c.p, c.k, c.coefficient, c.deadBand, c.drag, c.support);
    show("start", start.x, ", "), show("v_start", start.v, ", "), show("lengths", c.lengths, ", ");
    show("masses", c.masses, ", "), show("gaps", c.gaps, ", "), show("forces", c.forces, ", ");
    printf("\"states\": [%s]}\n", states.c_str());
    fflush(stdout);
}

int main(int count, char** words) {
    if (count < 3) return fprintf(stderr, "random_arcs FIRST END\n"), 1;
    const Nodes many(22), fewer(18), few(12);
    for (int number = atoi(words[1]); number < atoi(words[2]); number++) follow(number, many, fewer, few);
}
