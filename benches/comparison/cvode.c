/* The ten-minute run by SUNDIALS CVODE, for comparison.
 *
 *     cvode adams|bdf <relative tolerance> <absolute tolerance> <end time in s>
 *
 * prints one line: seconds, steps, evaluations of the right-hand side, relative energy error, version of SUNDIALS.
 *
 * The whole cradle is one system y' = f(y), the contact forces switch with the positions within f, and the error
 * control finds the contacts by itself. Adams with the fixed-point iteration, as for problems that are not stiff; BDF
 * with Newton's method and the exact Jacobian, banded because only neighbours interact.
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

/* Figure 6's set-up: masses of 1 kg, two balls lifted by 1 m. The state is x1, v1, x2, v2, ... */
enum { BALLS = 5, LIFTED = 2 };
static const double OMEGA2 = 9.81 / 1.962, STIFFNESS = 2.9e14, DEAD_BAND = 1.46e-7, AMPLITUDE = 1.0;

static double contact_force(const double *y, int i)
{
    double overlap = y[2 * i] - y[2 * i + 2] - DEAD_BAND;
    return overlap > 0.0 ? STIFFNESS * overlap : 0.0;
}

static int motion(double t, N_Vector state, N_Vector rates, void *user)
{
    (void)t, (void)user;
    const double *y = N_VGetArrayPointer(state);
    double *rate = N_VGetArrayPointer(rates);
    double from_left = 0.0;
    for (int i = 0; i < BALLS; i++) {
        double from_right = i + 1 < BALLS ? contact_force(y, i) : 0.0;
        rate[2 * i] = y[2 * i + 1];
        rate[2 * i + 1] = from_left - from_right - OMEGA2 * y[2 * i];
        from_left = from_right;
    }
    return 0;
}

static int jacobian(double t, N_Vector state, N_Vector rates, SUNMatrix matrix, void *user, N_Vector a, N_Vector b,
                    N_Vector c)
{
    (void)t, (void)rates, (void)user, (void)a, (void)b, (void)c;
    const double *y = N_VGetArrayPointer(state);
    SUNMatZero(matrix);
    for (int i = 0; i < BALLS; i++) {
        double left = i > 0 && contact_force(y, i - 1) > 0.0 ? STIFFNESS : 0.0;
        double right = i + 1 < BALLS && contact_force(y, i) > 0.0 ? STIFFNESS : 0.0;
        SM_ELEMENT_B(matrix, 2 * i, 2 * i + 1) = 1.0;
        SM_ELEMENT_B(matrix, 2 * i + 1, 2 * i) = -OMEGA2 - left - right;
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
        sum += 0.5 * (y[2 * i + 1] * y[2 * i + 1] + OMEGA2 * y[2 * i] * y[2 * i]);
        if (i + 1 < BALLS)
            sum += 0.5 * contact_force(y, i) * contact_force(y, i) / STIFFNESS;
    }
    return sum;
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
    if (count != 5) {
        fprintf(stderr, "usage: cvode adams|bdf <relative tolerance> <absolute tolerance> <end time>\n");
        return 2;
    }
    int bdf = strcmp(arguments[1], "bdf") == 0;
    double relative = atof(arguments[2]), absolute = atof(arguments[3]), end = atof(arguments[4]);

    SUNContext context;
    check(SUNContext_Create(NO_COMMUNICATOR, &context), "SUNContext_Create");
    N_Vector state = N_VNew_Serial(2 * BALLS, context);
    double *y = N_VGetArrayPointer(state);
    for (int i = 0; i < BALLS; i++) {
        y[2 * i] = i < LIFTED ? -AMPLITUDE : 0.0;
        y[2 * i + 1] = 0.0;
    }
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
