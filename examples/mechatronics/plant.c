/* The plant in C: an FMU that needs nothing of its host. For your own, change the variables, here and in plant.xml,
   their `rates`, and which outputs fmi2DoStep makes of them. pack.py compiles it, with plant.xml's GUID as a macro. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define PI 3.14159265358979323846
#define SUBSTEP 1e-4 /* s, of the Runge-Kutta method; the fastest time constant, of the coil, is 20 ms */

/* Value references: the variables in the order of plant.xml, which has their units and meanings. */
enum {
    mass, stiffness, damping, force_constant, resistance, inductance, gain, pull, pull_time,
    F_support, F_support_rate, v_coil, v_coil_rate, F_sensor,
    s, v, i, q,
    a_mean, F_coil_mean, a, a_rate, F_coil, F_coil_rate, coil_work, damper_loss, sensed,
    last_step, pulses, impacts, COUNT
};

static const double START[COUNT] = {
    [mass] = 2.0, [stiffness] = 150.0, [damping] = 1.0, [force_constant] = 1.0, [resistance] = 5.0,
    [inductance] = 0.2, [gain] = 5.0, [pull] = -0.8, [pull_time] = 1.6,
};

/* The equations: the rates of what changes during a step, at the time t. */
static void rates(const double *p, double t, double *rate)
{
    double shape = t < p[pull_time] ? pow(sin(PI * t / p[pull_time]), 2) : 0.0;
    double loop = (p[resistance] + p[gain]) * (p[pull] * shape - p[i]);
    double force = p[F_support] - p[force_constant] * p[i] - p[stiffness] * p[s] - p[damping] * p[v];
    rate[F_support] = p[F_support_rate];
    rate[v_coil] = p[v_coil_rate];
    rate[s] = p[v];
    rate[v] = force / p[mass];
    rate[i] = (loop - p[force_constant] * p[v_coil]) / p[inductance];
    rate[q] = p[i];
    rate[coil_work] = p[force_constant] * p[i] * p[v_coil];
    rate[damper_loss] = p[damping] * p[v] * p[v];
}

/* The classical Runge-Kutta method of order 4, from t to t + h. */
static void integrate(double *p, double t, double h)
{
    static const double node[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    double at[COUNT], rate[COUNT] = {0.0}, sum[COUNT] = {0.0};
    for (int stage = 0; stage < 4; stage++) {
        for (int k = 0; k < COUNT; k++) at[k] = p[k] + node[stage] * h * rate[k];
        rates(at, t + node[stage] * h, rate);
        for (int k = 0; k < COUNT; k++) sum[k] += weight[stage] * rate[k];
    }
    for (int k = 0; k < COUNT; k++) p[k] += h / 6.0 * sum[k];
}

/* A communication step, of length h, s. */
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final)
{
    double *p = c, before[COUNT], soon[COUNT], rate[COUNT] = {0.0}, later[COUNT] = {0.0};
    int substeps = (int)ceil(h / SUBSTEP);
    memcpy(before, p, sizeof before);
    /* What the cradle reports is the mean over its last step, as long as the one done here. */
    p[sensed] += p[F_sensor] * p[last_step];
    if (p[F_sensor] > 0.0) p[impacts] = p[pulses];
    for (int k = 0; k < substeps; k++) integrate(p, t + k * h / substeps, h / substeps);
    rates(p, t + h, rate);
    for (int k = 0; k < COUNT; k++) soon[k] = p[k] + SUBSTEP * rate[k];
    rates(soon, t + h + SUBSTEP, later);
    p[a_mean] = (p[v] - before[v]) / h;
    p[F_coil_mean] = p[force_constant] * (p[q] - before[q]) / h;
    p[a] = rate[v];
    p[F_coil] = p[force_constant] * p[i];
    p[F_coil_rate] = p[force_constant] * rate[i];
    p[a_rate] = (later[v] - rate[v]) / SUBSTEP;
    p[last_step] = h;
    p[F_support] = before[F_support];
    p[v_coil] = before[v_coil];
    return fmi2OK;
}

/* ---------------------------------------------------------------- what FMI asks of any slave */

const char *fmi2GetVersion(void) { return fmi2Version; }
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    fmi2Component c = type == fmi2CoSimulation && !strcmp(guid, GUID) ? malloc(sizeof START) : NULL;
    return c ? memcpy(c, START, sizeof START) : NULL;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!*state) *state = malloc(sizeof START);
    return *state && memcpy(*state, c, sizeof START) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    memcpy(c, state, sizeof START);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) { return fmi2SetFMUstate(c, (fmi2FMUstate)START); }

#define ACCESS(name, values, access)                                                             \
    fmi2Status name(fmi2Component c, const fmi2ValueReference reference[], size_t count, values) \
    {                                                                                            \
        double *p = c;                                                                           \
        for (size_t k = 0; k < count; k++) {                                                     \
            if (reference[k] >= COUNT) return fmi2Error;                                         \
            access;                                                                              \
        }                                                                                        \
        return fmi2OK;                                                                           \
    }
ACCESS(fmi2GetReal, fmi2Real value[], value[k] = p[reference[k]])
ACCESS(fmi2SetReal, const fmi2Real value[], p[reference[k]] = value[k])
ACCESS(fmi2GetInteger, fmi2Integer value[], value[k] = (fmi2Integer)p[reference[k]])
ACCESS(fmi2SetInteger, const fmi2Integer value[], p[reference[k]] = value[k])

#define ANSWER(status, name, ...) fmi2Status name(__VA_ARGS__) { return status; }
typedef const fmi2ValueReference *References;
ANSWER(fmi2OK, fmi2SetDebugLogging, fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
ANSWER(fmi2OK, fmi2SetupExperiment, fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
       fmi2Boolean has_stop, fmi2Real stop)
ANSWER(fmi2OK, fmi2EnterInitializationMode, fmi2Component c)
ANSWER(fmi2OK, fmi2ExitInitializationMode, fmi2Component c)
ANSWER(fmi2OK, fmi2Terminate, fmi2Component c)

/* What this slave has not, but hosts look for. */
ANSWER(fmi2Error, fmi2GetBoolean, fmi2Component c, References of, size_t count, fmi2Boolean value[])
ANSWER(fmi2Error, fmi2SetBoolean, fmi2Component c, References of, size_t count, const fmi2Boolean value[])
ANSWER(fmi2Error, fmi2GetString, fmi2Component c, References of, size_t count, fmi2String value[])
ANSWER(fmi2Error, fmi2SetString, fmi2Component c, References of, size_t count, const fmi2String value[])
ANSWER(fmi2Error, fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate state, size_t *size)
ANSWER(fmi2Error, fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
ANSWER(fmi2Error, fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
ANSWER(fmi2Error, fmi2GetDirectionalDerivative, fmi2Component c, References of, size_t count, References by,
       size_t by_count, const fmi2Real seed[], fmi2Real value[])
ANSWER(fmi2Error, fmi2SetRealInputDerivatives, fmi2Component c, References of, size_t count, const fmi2Integer order[],
       const fmi2Real value[])
ANSWER(fmi2Error, fmi2GetRealOutputDerivatives, fmi2Component c, References of, size_t count, const fmi2Integer order[],
       fmi2Real value[])
ANSWER(fmi2Error, fmi2CancelStep, fmi2Component c)
ANSWER(fmi2Error, fmi2GetStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
ANSWER(fmi2Error, fmi2GetRealStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
ANSWER(fmi2Error, fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
ANSWER(fmi2Error, fmi2GetBooleanStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
ANSWER(fmi2Error, fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
