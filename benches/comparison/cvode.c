/* The same runs by SUNDIALS CVODE, for comparison.
 *
 *     cvode linear|arcs|cubic|hertz|hunt-crossley|viscoelastic adams|bdf <rtol> <atol> <end time in s>
 *
 * prints one line: seconds, steps, evaluations of the right-hand side, relative energy error, version of SUNDIALS.
 *
 * The whole cradle is one system y' = f(y), the contact forces switch with the positions within f, and the error
 * control finds the contacts by itself. Adams with the fixed-point iteration, as for problems that are not stiff; BDF
 * with Newton's method and the exact Jacobian, banded because only neighbours interact; on lines without damping only.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#if SUNDIALS_VERSION_MAJOR < 6
#error "SUNDIALS 6 or newer is needed"
#elif SUNDIALS_VERSION_MAJOR == 6
#define NO_COMMUNICATOR NULL
#else
#define NO_COMMUNICATOR SUN_COMM_NULL
#endif

/* Masses of 1 kg, two balls lifted. The state is x1, v1, x2, v2, ..., and with damping the energy lost; on arcs, angles
 * and their rates. */
enum { BALLS = 5, LIFTED = 2, LOSS = 2 * BALLS };
struct cradle {
    const char *name;
    double omega2, stiffness, dead_band, amplitude, exponent;
    double hunt_crossley, relaxation_time; /* s/m, s */
    double length, radius;                 /* of arcs and balls, m; length 0: on lines */
};
#define STEEL 9.81 / 1.962, 19246147697.225853, 0.0, 0.1, 1.5 /* balls of the default radius, in touch */
static const struct cradle CRADLES[] = {
    {"linear", 9.81 / 1.962, 2.9e14, 1.46e-7, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0}, /* Figure 6's set-up */
    {"arcs", 9.81 / 1.962, 2.9e14, 1.46e-7, 1.0, 1.0, 0.0, 0.0, 1.962, 0.0313},
    {"cubic", 39.47841760435743, 5e18, 2e-5, 0.05, 3.0, 0.0, 0.0, 0.0, 0.0},
    {"hertz", STEEL, 0.0, 0.0, 0.0, 0.0},
    {"hunt-crossley", STEEL, 0.05, 0.0, 0.0, 0.0},
    {"viscoelastic", STEEL, 0.0, 4e-7, 0.0, 0.0},
};
static struct cradle cradle;

static int is_damped(void)
{
    return cradle.hunt_crossley > 0.0 || cradle.relaxation_time > 0.0;
}

/* What the state of a ball is multiplied by for lengths and speeds along its path, m. */
static double arm(void)
{
    return cradle.length > 0.0 ? cradle.length : 1.0;
}

/* The overlap of contact i, on arcs without cancellation, and how much of its force is along the paths of the balls. */
static double overlap(const double *y, int i, double along[2])
{
    double left = y[2 * i], right = y[2 * i + 2];
    along[0] = along[1] = 1.0;
    if (cradle.length == 0.0)
        return fmax(left - right - cradle.dead_band, 0.0);
    double mean = 0.5 * (left + right), pivots = 2.0 * cradle.radius;
    double chord = 2.0 * cradle.length * sin(0.5 * (right - left));
    double wider = chord * cos(mean), height = chord * sin(mean), width = pivots + wider;
    double distance = sqrt(width * width + height * height);
    double overlap = -(wider * (pivots + width) + height * height) / (distance + pivots) - cradle.dead_band;
    if (overlap <= 0.0)
        return 0.0;
    along[0] = (width * cos(left) + height * sin(left)) / distance;
    along[1] = (width * cos(right) + height * sin(right)) / distance;
    return overlap;
}

static double elastic_force(double d)
{
    if (cradle.exponent == 1.0)
        return cradle.stiffness * d;
    return cradle.stiffness * d * (cradle.exponent == 1.5 ? sqrt(d) : d * d);
}

static double damped_force(double d, double elastic, double rate)
{
    if (d == 0.0)
        return 0.0;
    double factor = cradle.hunt_crossley + cradle.relaxation_time * cradle.exponent / d;
    return fmax(elastic * (1.0 + factor * rate), 0.0);
}

static double contact_stiffness(const double *y, int i)
{
    double along[2], d = overlap(y, i, along);
    return d == 0.0 ? 0.0 : cradle.exponent * elastic_force(d) / d;
}

static int motion(double t, N_Vector state, N_Vector rates, void *user)
{
    (void)t, (void)user;
    const double *y = N_VGetArrayPointer(state);
    double *rate = N_VGetArrayPointer(rates);
    double from_left = 0.0, loss = 0.0;
    int damped = is_damped();
    for (int i = 0; i < BALLS; i++) {
        double force = 0.0, along[2] = {1.0, 1.0};
        if (i + 1 < BALLS) {
            double d = overlap(y, i, along), elastic = elastic_force(d), approach = y[2 * i + 1] - y[2 * i + 3];
            force = damped ? damped_force(d, elastic, approach) : elastic;
            loss += (force - elastic) * approach;
        }
        double back = cradle.omega2 * (cradle.length > 0.0 ? sin(y[2 * i]) : y[2 * i]);
        rate[2 * i] = y[2 * i + 1];
        rate[2 * i + 1] = (from_left - force * along[0]) / arm() - back;
        from_left = force * along[1];
    }
    if (damped)
        rate[LOSS] = loss;
    return 0;
}

static int jacobian(double t, N_Vector state, N_Vector rates, SUNMatrix matrix, void *user, N_Vector a, N_Vector b,
                    N_Vector c)
{
    (void)t, (void)rates, (void)user, (void)a, (void)b, (void)c;
    const double *y = N_VGetArrayPointer(state);
    SUNMatZero(matrix);
    for (int i = 0; i < BALLS; i++) {
        double left = i > 0 ? contact_stiffness(y, i - 1) : 0.0;
        double right = i + 1 < BALLS ? contact_stiffness(y, i) : 0.0;
        SM_ELEMENT_B(matrix, 2 * i, 2 * i + 1) = 1.0;
        SM_ELEMENT_B(matrix, 2 * i + 1, 2 * i) = -cradle.omega2 - left - right;
        if (i > 0)
            SM_ELEMENT_B(matrix, 2 * i + 1, 2 * i - 2) = left;
        if (i + 1 < BALLS)
            SM_ELEMENT_B(matrix, 2 * i + 1, 2 * i + 2) = right;
    }
    return 0;
}

static double energy(const double *y)
{
    double sum = 0.0;
    for (int i = 0; i < BALLS; i++) {
        double swing = arm() * (cradle.length > 0.0 ? 2.0 * sin(0.5 * y[2 * i]) : y[2 * i]);
        double speed = arm() * y[2 * i + 1];
        sum += 0.5 * (speed * speed + cradle.omega2 * swing * swing);
        if (i + 1 < BALLS) {
            double along[2], d = overlap(y, i, along);
            sum += elastic_force(d) * d / (cradle.exponent + 1.0);
        }
    }
    return is_damped() ? sum + y[LOSS] : sum;
}

static void check(int code, const char *what)
{
    if (code < 0) {
        fprintf(stderr, "%s failed with code %d\n", what, code);
        exit(1);
    }
}

int main(int count, char **arguments)
{
    if (count != 6) {
        fprintf(stderr, "usage: cvode <contacts> adams|bdf <relative tolerance> <absolute tolerance> <end time>\n");
        return 2;
    }
    for (size_t i = 0; i < sizeof CRADLES / sizeof *CRADLES; i++)
        if (strcmp(arguments[1], CRADLES[i].name) == 0)
            cradle = CRADLES[i];
    int bdf = strcmp(arguments[2], "bdf") == 0;
    double relative = atof(arguments[3]), absolute = atof(arguments[4]), end = atof(arguments[5]);

    SUNContext context;
    check(SUNContext_Create(NO_COMMUNICATOR, &context), "SUNContext_Create");
    N_Vector state = N_VNew_Serial(2 * BALLS + is_damped(), context);
    double *y = N_VGetArrayPointer(state);
    for (int i = 0; i < BALLS; i++) {
        double lift = cradle.length > 0.0 ? asin(cradle.amplitude / cradle.length) : cradle.amplitude;
        y[2 * i] = i < LIFTED ? -lift : 0.0;
        y[2 * i + 1] = 0.0;
    }
    if (is_damped())
        y[LOSS] = 0.0;
    double at_start = energy(y);

    void *solver = CVodeCreate(bdf ? CV_BDF : CV_ADAMS, context);
    check(CVodeInit(solver, motion, 0.0, state), "CVodeInit");
    check(CVodeSStolerances(solver, relative, absolute), "CVodeSStolerances");
    check(CVodeSetMaxNumSteps(solver, -1), "CVodeSetMaxNumSteps");
    check(CVodeSetMaxErrTestFails(solver, 100), "CVodeSetMaxErrTestFails");
    check(CVodeSetMaxConvFails(solver, 100), "CVodeSetMaxConvFails");
    if (bdf) {
        SUNMatrix matrix = SUNBandMatrix(2 * BALLS, 1, 3, context);
        SUNLinearSolver linear = SUNLinSol_Band(state, matrix, context);
        check(CVodeSetLinearSolver(solver, linear, matrix), "CVodeSetLinearSolver");
        check(CVodeSetJacFn(solver, jacobian), "CVodeSetJacFn");
    } else {
        SUNNonlinearSolver iteration = SUNNonlinSol_FixedPoint(state, 0, context);
        check(CVodeSetNonlinearSolver(solver, iteration), "CVodeSetNonlinearSolver");
    }

    struct timespec begin, finish;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    double reached;
    check(CVodeSetStopTime(solver, end), "CVodeSetStopTime");
    check(CVode(solver, end, state, &reached, CV_NORMAL), "CVode");
    clock_gettime(CLOCK_MONOTONIC, &finish);

    long steps, evaluations;
    CVodeGetNumSteps(solver, &steps);
    CVodeGetNumRhsEvals(solver, &evaluations);
    double seconds = (finish.tv_sec - begin.tv_sec) + 1e-9 * (finish.tv_nsec - begin.tv_nsec);
    printf("%.6f %ld %ld %.3e %s\n", seconds, steps, evaluations, fabs(energy(y) / at_start - 1.0), SUNDIALS_VERSION);
    return 0;
}
